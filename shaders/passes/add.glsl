// sum += factor * term, for n three-vectors.

#include "common/each.glsl"

layout(std430) readonly buffer b_term { float term[]; };
layout(std430) buffer b_sum { float sum[]; };

uniform int u_count;
uniform vec3 u_factor;

void main()
{
    for (EACH(i, u_count))
        for (int c = 0; c < 3; c++)
            sum[3 * i + c] += u_factor[c] * term[3 * i + c];
}
