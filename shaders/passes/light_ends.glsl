// List the pixels where light ends: HIDDEN and VISIBLE both hold within so many steps to one of
// four neighbours; twin of `light_edges` in engine/backend/cpu/shading.py.

#include "common/each.glsl"

layout(std430) readonly buffer b_visible { int visible[]; };
layout(std430) readonly buffer b_flags { int flags[]; }; // 4: the pixel has samples of its own
layout(std430) buffer b_list { int listed; int pixels[]; };

uniform int u_count;
uniform int u_width;
uniform int u_reach;

void main()
{
    for (EACH(i, u_count)) {
        if ((flags[i] & 4) != 0)
            continue;
        int row = i / u_width, column = i % u_width, found = 0;
        for (int y = max(0, row - u_reach); y <= min(u_count / u_width - 1, row + u_reach); y++) {
            int left = u_reach - abs(y - row);
            for (int x = max(0, column - left); x <= min(u_width - 1, column + left); x++)
                found |= visible[y * u_width + x];
        }
        if (found == 3)
            pixels[atomicAdd(listed, 1)] = i;
    }
}
