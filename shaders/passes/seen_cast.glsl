// What rays from the eye meet, through the centres of pixels or through four places in each.

#include "common/bvh.glsl"
#include "common/each.glsl"
#include "common/seen.glsl"

layout(std430) readonly buffer b_list { int listed; int pixels[]; };
layout(std430) writeonly buffer b_seen { Seen seen[]; };

uniform int u_count;       // all pixels, or -1 for those that are listed
uniform vec2 u_offsets[4]; // of a pixel's rays
uniform int u_each;        // how many those are: of four, each has a place of its own in the list's order

void main()
{
    int count = u_count < 0 ? listed : u_count;
    for (EACH(k, u_each * count)) {
        int i = u_count < 0 ? pixels[k / u_each] : k;
        vec3 w = ray(i, u_offsets[k % u_each]);
        seen[u_each == 1 ? i : k] = meet(nearest(u_eye, w), w);
    }
}
