// Through the pixels' centres: what is seen of a lamp.

#include "common/each.glsl"
#include "passes/lamp.glsl"

layout(std430) writeonly buffer b_shown { vec4 shown[]; };

void main()
{
    for (EACH(i, u_count))
        shown[i] = see_lamp(i, vec2(0.0));
}
