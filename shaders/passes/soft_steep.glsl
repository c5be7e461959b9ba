// Where what pixels see of a light changes fast; twin of `changes_fast` in
// engine/backend/cpu/penumbra.py.

#include "common/each.glsl"

layout(std430) readonly buffer b_flags { int flags[]; }; // 1, 2: alike to the right, below
layout(std430) readonly buffer b_around { int around[]; }; // elsewhere all of it is seen, or none
layout(std430) readonly buffer b_part { vec2 part[]; };
layout(std430) writeonly buffer b_steep { int steep[]; };

uniform int u_count;
uniform int u_width;
uniform float u_steep; // change from pixel to pixel

// The part of the light that pixel i sees.
float part_of(int i)
{
    return around[i] == 0 ? 1.0 : part[i].y > 0.0 ? part[i].x / part[i].y : 0.0;
}

bool changes_fast(int i)
{
    int column = i % u_width;
    bool within = (flags[i] & 3) == 3 && column > 0 && i >= u_width;
    if (!within || (flags[i - 1] & 1) == 0 || (flags[i - u_width] & 2) == 0)
        return true;
    float across = part_of(i + min(2, u_width - 1 - column)) - part_of(i - min(2, column));
    float down = part_of(i + 2 * u_width < u_count ? i + 2 * u_width : i)
        - part_of(i >= 2 * u_width ? i - 2 * u_width : i);
    return max(abs(across), abs(down)) > 4.0 * u_steep;
}

void main()
{
    for (EACH(i, u_count))
        steep[i] = int(around[i] != 0 && changes_fast(i));
}
