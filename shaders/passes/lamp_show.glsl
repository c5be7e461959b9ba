// Lay what is seen of a lamp over the picture. A lamp ends sharply and far brighter than what is
// behind it, so its outline gets a finer grid, where `u_fine`.

#include "common/each.glsl"
#include "passes/lamp.glsl"

layout(std430) readonly buffer b_shown { vec4 shown[]; };
layout(std430) readonly buffer b_offsets { vec2 offsets[]; }; // in pixels
layout(std430) buffer b_sum { float sum[]; };

uniform int u_fine;

// Whether one of the four neighbours sees the lamp where pixel i does not, or the other way round.
bool on_outline(int i)
{
    int column = i % u_width;
    float here = shown[i].w;
    return (column > 0 && shown[i - 1].w != here)
        || (column < u_width - 1 && shown[i + 1].w != here)
        || (i >= u_width && shown[i - u_width].w != here)
        || (i + u_width < u_count && shown[i + u_width].w != here);
}

void main()
{
    for (EACH(i, u_count)) {
        vec4 lamp = shown[i];
        if (u_fine != 0 && on_outline(i)) {
            lamp = vec4(0.0);
            for (int k = 0; k < offsets.length(); k++)
                lamp += see_lamp(i, offsets[k]);
            lamp /= float(offsets.length());
        }
        if (lamp.w > 0.0)
            for (int c = 0; c < 3; c++)
                sum[3 * i + c] = sum[3 * i + c] * (1.0 - lamp.w) + lamp[c];
    }
}
