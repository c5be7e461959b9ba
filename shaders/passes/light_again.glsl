// The light of one light on the listed pixels, from more of its places.

#include "common/each.glsl"
#include "passes/shade.glsl"

layout(std430) readonly buffer b_list { int listed; int pixels[]; };
layout(std430) writeonly buffer b_radiance { float radiance[]; };

void main()
{
    for (EACH(j, listed)) {
        int i = pixels[j], seen;
        vec3 sum = light_at(i, points[i].position, seen);
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = sum[c];
    }
}
