// One direction of the tent over what the pixels around see of a light; twin of `mean_seen` in
// engine/backend/cpu/penumbra.py.

#include "common/each.glsl"

layout(std430) readonly buffer b_flags { int flags[]; }; // 1, 2: alike to the right, below
layout(std430) readonly buffer b_source { vec2 source[]; };
layout(std430) readonly buffer b_around { int around[]; }; // elsewhere nothing changes
layout(std430) writeonly buffer b_target { vec2 target[]; };

uniform int u_count;
uniform int u_step; // pixels to the next: 1 across, the width down
uniform int u_way; // its bit in the flags
uniform int u_reach; // pixels to where the weights are 0

void main()
{
    for (EACH(i, u_count)) {
        if (around[i] == 0) {
            target[i] = source[i];
            continue;
        }
        vec2 sum = float(u_reach) * source[i];
        int before = i, behind = i;
        for (int weight = u_reach - 1; weight > 0; weight--) {
            before = before >= u_step && (flags[before - u_step] & u_way) != 0 ? before - u_step : -1;
            behind = behind >= 0 && (flags[behind] & u_way) != 0 ? behind + u_step : -1;
            if (before >= 0)
                sum += float(weight) * source[before];
            if (behind >= 0)
                sum += float(weight) * source[behind];
        }
        target[i] = sum / float(u_reach * u_reach);
    }
}
