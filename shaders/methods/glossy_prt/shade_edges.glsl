// Pixels at edges: the mean over their sub-samples.

#include "common/each.glsl"
#include "methods/glossy_prt/radiance.glsl"

layout(std430) readonly buffer b_list { int listed; int pixels[]; };
layout(std430) readonly buffer b_seen { Seen seen[]; };
layout(std430) writeonly buffer b_image { float image[]; };

uniform vec2 u_offsets[4]; // of the sub-samples

void main()
{
    for (EACH(e, listed)) {
        int i = pixels[e];
        vec3 sum = vec3(0.0);
        for (int k = 0; k < 4; k++)
            sum += radiance(seen[4 * e + k], ray(i, u_offsets[k]));
        for (int c = 0; c < 3; c++)
            image[3 * i + c] = 0.25 * sum[c];
    }
}
