// The light of one light with extent on all pixels, by what the pixels around have found out about
// it: in full light a few of its places and no rays, in a penumbra many with rays, else none. Twin
// of `_soft_light` in engine/methods/fixed_view/direct.py.

#include "common/each.glsl"
#include "passes/shade.glsl"

layout(std430) readonly buffer b_visible { int visible[]; };
layout(std430) writeonly buffer b_radiance { float radiance[]; };

uniform int u_count;
uniform int u_width;
uniform int u_reach; // pixels each way
uniform int u_per_penumbra; // places; their groups follow those for full light

// What holds in the square of pixels around pixel i; twin of `seen_around`.
int seen_around(int i)
{
    int row = i / u_width, column = i % u_width, found = 0;
    for (int y = max(0, row - u_reach); y <= min(u_count / u_width - 1, row + u_reach); y++)
        for (int x = max(0, column - u_reach); x <= min(u_width - 1, column + u_reach); x++)
            found |= visible[y * u_width + x];
    return found;
}

void main()
{
    for (EACH(i, u_count)) {
        int near = seen_around(i), group = points[i].phase % u_groups, seen;
        vec3 sum = vec3(0.0);
        if (near == VISIBLE)
            sum = light_at(i, points[i].position, group * u_per_point, u_per_point, false, seen);
        else if (near == (HIDDEN | VISIBLE)) {
            int first = u_groups * u_per_point + group * u_per_penumbra;
            sum = light_at(i, points[i].position, first, u_per_penumbra, true, seen);
        }
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = sum[c];
    }
}
