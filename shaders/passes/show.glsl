// Lay what the camera sees of a light itself over the picture.

#include "common/each.glsl"

layout(std430) readonly buffer b_pixels { int pixels[]; };
layout(std430) readonly buffer b_shown { vec4 shown[]; }; // radiance times cover, and cover
layout(std430) buffer b_sum { float sum[]; };

uniform int u_count;

void main()
{
    for (EACH(j, u_count))
        for (int c = 0; c < 3; c++) {
            int k = 3 * pixels[j] + c;
            sum[k] = sum[k] * (1.0 - shown[j].w) + shown[j][c];
        }
}
