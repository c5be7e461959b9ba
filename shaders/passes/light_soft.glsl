// Ask a light with extent by what the pixels around have found out about it. Matt pixels of a
// penumbra ask a few of its places; glossy ones are lit, in full light by a few places and no rays, in
// a penumbra by many with rays. Twin of `_soft_light` in engine/methods/fixed_view/direct.py.

#include "common/each.glsl"
#include "passes/soft.glsl"

layout(std430) readonly buffer b_visible { int visible[]; };
layout(std430) writeonly buffer b_near { int near[]; };
layout(std430) writeonly buffer b_seen { vec2 seen[]; };
layout(std430) writeonly buffer b_radiance { float radiance[]; };

uniform int u_count;
uniform int u_width;
uniform int u_reach; // pixels each way
uniform ivec3 u_lit; // first place, groups, places in each: where all of the light is seen,
uniform ivec3 u_penumbra; // where some of it is, of glossy pixels
uniform ivec3 u_wide; // and of matt ones

// What holds in the square of pixels around pixel i; twin of `seen_around`.
int seen_around(int i)
{
    int row = i / u_width, column = i % u_width, found = 0;
    for (int y = max(0, row - u_reach); y <= min(u_count / u_width - 1, row + u_reach); y++)
        for (int x = max(0, column - u_reach); x <= min(u_width - 1, column + u_reach); x++)
            found |= visible[y * u_width + x];
    return found;
}

// The first of the places of point i.
int first_place(int i, ivec3 places)
{
    return places.x + points[i].phase % places.y * places.z;
}

void main()
{
    for (EACH(i, u_count)) {
        int around = seen_around(i), found;
        bool partly = around == (HIDDEN | VISIBLE), matt = is_matt(i);
        vec3 sum = vec3(0.0), x = points[i].position;
        if (matt && partly)
            seen[i] = look(i, u_wide, found);
        else if (!matt && partly)
            sum = light_at(i, x, first_place(i, u_penumbra), u_penumbra.z, true, found);
        else if (!matt && around == VISIBLE)
            sum = light_at(i, x, first_place(i, u_lit), u_lit.z, false, found);
        near[i] = matt ? around : -1; // glossy, or no surface
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = sum[c];
    }
}
