// What the camera sees of a light with extent itself; twin of `_see_lamp` in
// engine/methods/fixed_view/view.py.

#include "common/pixels.glsl"
#include "light/chosen.glsl"

layout(std430) readonly buffer b_light { float light[LIGHT_ROW]; };

uniform vec3 u_eye;

// Radiance times cover, and cover, of a ray through pixel i moved by so many pixels.
vec4 see_lamp(int i, vec2 offset)
{
    vec3 d = neighbour_ray(i, offset), g = points[i].geometric;
    vec4 seen = emitted(light, u_eye, d);
    if (seen.w < 0.0)
        return vec4(0.0);
    float slope = dot(d, g), height = dot(points[i].position - u_eye, g);
    bool hidden = points[i].model >= 0 && slope != 0.0 && seen.w >= height / slope;
    return hidden ? vec4(0.0) : vec4(seen.rgb, 1.0);
}
