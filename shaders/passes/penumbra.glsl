// One direction of the tent over the 3 x 3 around each pixel; twin of `smooth_penumbrae` in
// engine/backend/cpu/penumbra.py. First across, which takes what is reflected and leaves what
// arrives, then down, which is the other way round.

#include "common/each.glsl"
#include "common/points.glsl"

layout(std430) readonly buffer b_flags { int flags[]; }; // 1, 2: alike to the right, below
layout(std430) readonly buffer b_source { float source[]; };
layout(std430) writeonly buffer b_target { float target[]; };

uniform int u_count;
uniform int u_step; // pixels to the next: 1 across, the width down
uniform int u_way; // its bit in the flags

vec3 reflectance(int i)
{
    return vec3(points[i].row[0] + points[i].row[3], points[i].row[1] + points[i].row[4],
                points[i].row[2] + points[i].row[5]);
}

vec3 arriving(int i)
{
    vec3 value = vec3(source[3 * i], source[3 * i + 1], source[3 * i + 2]);
    if (u_way != 1)
        return value;
    vec3 k = reflectance(i);
    return mix(value / max(k, vec3(1e-30)), vec3(0.0), lessThanEqual(k, vec3(0.0)));
}

void main()
{
    for (EACH(i, u_count)) {
        // One neighbour for the other, or the pixel itself, where they are not alike.
        int before = i >= u_step && (flags[i - u_step] & u_way) != 0 ? i - u_step : i;
        int behind = (flags[i] & u_way) != 0 ? i + u_step : before;
        if (before == i)
            before = behind;
        vec3 mean = 0.5 * arriving(i) + 0.25 * (arriving(before) + arriving(behind));
        if (u_way != 1)
            mean *= reflectance(i);
        for (int c = 0; c < 3; c++)
            target[3 * i + c] = mean[c];
    }
}
