// One ray from every pixel to one place of a light with extent.

#include "common/each.glsl"
#include "passes/soft.glsl"

layout(std430) writeonly buffer b_visible { int visible[]; };
layout(std430) writeonly buffer b_seen { vec2 seen[]; };

uniform int u_count;

void main()
{
    for (EACH(i, u_count)) {
        int found;
        seen[i] = look(i, ivec3(0, u_groups, 1), found);
        visible[i] = found;
    }
}
