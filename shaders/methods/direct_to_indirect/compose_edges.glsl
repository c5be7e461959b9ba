// Add the indirect light of pixels with four sub-samples: each takes that of its donor.

#include "common/each.glsl"
#include "methods/direct_to_indirect/reflected.glsl"

layout(std430) readonly buffer b_edge { int edge[]; };
layout(std430) readonly buffer b_donor { int donor[]; };
layout(std430) buffer b_image { float image[]; };

uniform int u_edges;

void main()
{
    for (EACH(e, u_edges))
        for (int c = 0; c < 3; c++) {
            float sum = 0.0;
            for (int s = 4 * e; s < 4 * e + 4; s++)
                sum += reflected(3 * donor[s] + c, 3 * s + c);
            image[3 * edge[e] + c] += 0.25 * sum;
        }
}
