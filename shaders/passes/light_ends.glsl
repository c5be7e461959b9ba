// List the pixels where light ends: HIDDEN and VISIBLE both hold here or at one of the four
// neighbours; twin of `light_edges` in engine/backend/cpu/shading.py.

#include "common/each.glsl"

layout(std430) readonly buffer b_visible { int visible[]; };
layout(std430) readonly buffer b_flags { int flags[]; }; // 4: the pixel has samples of its own
layout(std430) buffer b_list { int listed; int pixels[]; };

uniform int u_count;
uniform int u_width;

void main()
{
    for (EACH(i, u_count)) {
        if ((flags[i] & 4) != 0)
            continue;
        int column = i % u_width, found = visible[i];
        if (column > 0)
            found |= visible[i - 1];
        if (column < u_width - 1)
            found |= visible[i + 1];
        if (i >= u_width)
            found |= visible[i - u_width];
        if (i + u_width < u_count)
            found |= visible[i + u_width];
        if (found == 3)
            pixels[atomicAdd(listed, 1)] = i;
    }
}
