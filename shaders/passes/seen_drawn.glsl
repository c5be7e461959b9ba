// Where the rays through all pixels meet the triangles that the rasteriser found.

#include "common/each.glsl"
#include "common/seen.glsl"

layout(std430) writeonly buffer b_seen { Seen seen[]; };

uniform isampler2D u_ids; // of triangles, from 1 on
uniform int u_count;

void main()
{
    for (EACH(i, u_count))
        seen[i] = meet(texelFetch(u_ids, ivec2(i % u_width, i / u_width), 0).x - 1, ray(i, vec2(0.0)));
}
