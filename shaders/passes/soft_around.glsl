// Pixels from which a marked one is less than u_reach pixels away each way.

#include "common/each.glsl"

layout(std430) readonly buffer b_marks { int marks[]; };
layout(std430) readonly buffer b_kept { int kept[]; };
layout(std430) writeonly buffer b_found { int found[]; };

uniform int u_count;
uniform int u_width;
uniform int u_reach;
uniform int u_mark; // what marks a pixel
uniform int u_kept; // others are left out where less is kept

void main()
{
    for (EACH(i, u_count)) {
        int row = i / u_width, column = i % u_width, last = u_count / u_width - 1, any = 0;
        for (int y = max(0, row - u_reach + 1); y <= min(last, row + u_reach - 1); y++)
            for (int x = max(0, column - u_reach + 1); x <= min(u_width - 1, column + u_reach - 1); x++)
                any |= int(marks[y * u_width + x] == u_mark);
        found[i] = kept[i] >= u_kept ? any : 0;
    }
}
