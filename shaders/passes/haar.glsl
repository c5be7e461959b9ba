// One level of the Haar transform of three-vectors in quad-tree order; twin of `_analyse` in
// engine/numerics/haar.py. Every thread takes one parent.

#include "common/each.glsl"

layout(std430) readonly buffer b_values { float values[]; };
// Scaling coefficients of all levels but the finest, the coarsest first: 1, 4, 16, ... of them.
layout(std430) buffer b_scaling { float scaling[]; };
layout(std430) writeonly buffer b_out { float coefficients[]; };

uniform int u_parents; // of this level, 4^l
uniform int u_finest; // whether the children are the values themselves

void main()
{
    int before = (u_parents - 1) / 3; // parents of coarser levels
    for (EACH(i, u_parents)) {
        for (int c = 0; c < 3; c++) {
            float v[4];
            for (int k = 0; k < 4; k++)
                v[k] = u_finest != 0 ? values[3 * (4 * i + k) + c]
                                     : scaling[3 * (before + u_parents + 4 * i + k) + c];
            float sum = 0.5 * (v[0] + v[1] + v[2] + v[3]);
            scaling[3 * (before + i) + c] = sum;
            int detail = 3 * (u_parents + 3 * i) + c;
            coefficients[detail] = 0.5 * (v[0] - v[1] + v[2] - v[3]);
            coefficients[detail + 3] = 0.5 * (v[0] + v[1] - v[2] - v[3]);
            coefficients[detail + 6] = 0.5 * (v[0] - v[1] - v[2] + v[3]);
            if (u_parents == 1)
                coefficients[c] = sum;
        }
    }
}
