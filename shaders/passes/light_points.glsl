// The light of one light on all points.

#include "common/each.glsl"
#include "passes/shade.glsl"

layout(std430) writeonly buffer b_radiance { float radiance[]; };
layout(std430) writeonly buffer b_visible { int visible[]; };

uniform int u_count;

void main()
{
    for (EACH(i, u_count)) {
        int seen;
        vec3 sum = light_at(i, points[i].position, seen);
        visible[i] = seen;
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = sum[c];
    }
}
