// Pixels of a penumbra by which it is narrow ask for more of the light's places.

#include "common/each.glsl"
#include "passes/soft.glsl"

layout(std430) readonly buffer b_near { int near[]; };
layout(std430) readonly buffer b_by { int by[]; };
layout(std430) writeonly buffer b_seen { vec2 seen[]; };

uniform int u_count;
uniform ivec3 u_penumbra; // first place, groups, places in each

void main()
{
    for (EACH(i, u_count)) {
        int visible;
        if (near[i] == (HIDDEN | VISIBLE) && by[i] != 0)
            seen[i] = look(i, u_penumbra, visible);
    }
}
