// The light of one light on pixels with four sub-samples, the mean over those.

#include "common/each.glsl"
#include "passes/shade.glsl"

layout(std430) readonly buffer b_edge { int edge[]; };
layout(std430) writeonly buffer b_radiance { float radiance[]; };

uniform int u_edges;

void main()
{
    for (EACH(e, u_edges)) {
        vec3 sum = vec3(0.0);
        int seen;
        for (int k = 4 * e; k < 4 * e + 4; k++)
            sum += light_at(k, points[k].position, seen);
        for (int c = 0; c < 3; c++)
            radiance[3 * edge[e] + c] = 0.25 * sum[c];
    }
}
