// A BRDF for many pairs of directions; twin of engine/brdf/arrays.py.

#include "brdf/table.glsl"
#include "common/each.glsl"

layout(std430) readonly buffer b_row { float row[BRDF_ROW]; };
layout(std430) readonly buffer b_wi { float wi[]; };
layout(std430) readonly buffer b_wo { float wo[]; };
layout(std430) writeonly buffer b_value { float value[]; };

uniform int u_count;
uniform int u_model;

void main()
{
    for (EACH(i, u_count)) {
        vec3 f = evaluate(u_model, row, vec3(wi[3 * i], wi[3 * i + 1], wi[3 * i + 2]),
                          vec3(wo[3 * i], wo[3 * i + 1], wo[3 * i + 2]));
        for (int c = 0; c < 3; c++)
            value[3 * i + c] = f[c];
    }
}
