// Add the indirect light of whole pixels to the direct.

#include "common/each.glsl"
#include "methods/direct_to_indirect/reflected.glsl"

layout(std430) buffer b_image { float image[]; };

uniform int u_count;

void main()
{
    for (EACH(i, 3 * u_count))
        image[i] += reflected(i, i);
}
