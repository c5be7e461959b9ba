// Rays through pixels; twin of `neighbour_ray` in engine/backend/cpu/shading.py.

#include "common/points.glsl"

uniform int u_count; // pixels
uniform int u_width;

// Direction from the eye through pixel i moved by so many pixels, about unit length.
vec3 neighbour_ray(int i, vec2 offset)
{
    vec3 d = -points[i].view;
    if (u_width > 1) {
        bool last = (i + 1) % u_width == 0;
        d += (points[last ? i - 1 : i + 1].view - points[i].view) * (last ? offset.x : -offset.x);
    }
    if (u_count > u_width) {
        bool last = i + u_width >= u_count;
        d += (points[last ? i - u_width : i + u_width].view - points[i].view)
            * (last ? offset.y : -offset.y);
    }
    return d;
}
