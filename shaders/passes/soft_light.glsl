// What a light with extent gives the matt pixels, times the part of it that each sees.

#include "common/each.glsl"
#include "passes/soft.glsl"

layout(std430) readonly buffer b_near { int near[]; };
layout(std430) readonly buffer b_around { int around[]; };
layout(std430) readonly buffer b_narrow { int narrow[]; };
layout(std430) readonly buffer b_part { vec2 part[]; }; // where a penumbra is wide
layout(std430) readonly buffer b_seen { vec2 seen[]; }; // where it is narrow
layout(std430) writeonly buffer b_radiance { float radiance[]; };

uniform int u_count;
uniform int u_every; // places, where there is no formula

void main()
{
    for (EACH(i, u_count)) {
        if (near[i] < 0)
            continue;
        vec3 value = vec3(0.0);
        vec2 sums = narrow[i] != 0 ? seen[i] : part[i];
        if (around[i] != 0 ? sums.x > 0.0 : near[i] == VISIBLE)
            value = unshadowed(i, 0, u_every) * (around[i] != 0 ? sums.x / sums.y : 1.0);
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = value[c];
    }
}
