// The picture without its edges: one ray through the centre of each pixel.

#include "common/each.glsl"
#include "methods/glossy_prt/radiance.glsl"

layout(std430) readonly buffer b_seen { Seen seen[]; };
layout(std430) writeonly buffer b_image { float image[]; };

uniform int u_count;

void main()
{
    for (EACH(i, u_count)) {
        vec3 found = radiance(seen[i], ray(i, vec2(0.0)));
        for (int c = 0; c < 3; c++)
            image[3 * i + c] = found[c];
    }
}
