// light *= gain * reflectance, for n three-vectors: what samples send on of what arrives.

#include "common/each.glsl"

layout(std430) readonly buffer b_reflected { float reflected[]; };
layout(std430) buffer b_light { float light[]; };

uniform int u_count;
uniform float u_gain;

void main()
{
    for (EACH(i, 3 * u_count))
        light[i] *= u_gain * reflected[i];
}
