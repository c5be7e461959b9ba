// The light of one light on the listed pixels, the mean over a grid of places on their tangent
// planes; twin of `on_tangent_planes` and `average` in engine/backend/cpu/shading.py.

#include "common/each.glsl"
#include "common/pixels.glsl"
#include "passes/shade.glsl"

layout(std430) readonly buffer b_list { int listed; int pixels[]; };
layout(std430) readonly buffer b_offsets { vec2 offsets[]; }; // in pixels
layout(std430) writeonly buffer b_radiance { float radiance[]; };

uniform vec3 u_eye;

void main()
{
    for (EACH(j, listed)) {
        int i = pixels[j], seen;
        vec3 x = points[i].position, g = points[i].geometric, sum = vec3(0.0);
        float height = dot(x - u_eye, g);
        for (int k = 0; k < offsets.length(); k++) {
            vec3 ray = neighbour_ray(i, offsets[k]);
            float slope = dot(ray, g);
            sum += light_at(i, slope > -1e-3 ? x : u_eye + ray * (height / slope), seen);
        }
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = sum[c] / float(offsets.length());
    }
}
