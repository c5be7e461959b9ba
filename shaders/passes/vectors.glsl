// Transport vectors of one material times a light; twin of engine/backend/cpu/vectors.py.
//
// A work group takes VECTORS vectors, and LANES of its threads share the coefficients of each, which
// lie one behind the other: neighbours read neighbours. What they find is added up in the end, BLOCK
// terms at a time.

layout(local_size_x = 64) in;
const int LANES = 64 / VECTORS, BLOCK = 4;

layout(std430) readonly buffer b_start { int start[]; };   // (r + 1)
layout(std430) readonly buffer b_base { float base[]; };   // (r, FACES, c)
layout(std430) readonly buffer b_scale { float scale[]; }; // (r, c)
layout(std430) readonly buffer b_place { uint place[]; };  // (q) two to a word
layout(std430) readonly buffer b_steps { int steps[]; };   // (q, c) signed bytes, four to a word
layout(std430) readonly buffer b_light { float light[]; }; // (FACES u_size, 3)
layout(std430) buffer b_lit { float lit[]; };              // (rows, 3)

uniform int u_count;    // r
uniform int u_terms;    // K
uniform int u_channels; // 1, or 3: the terms of red, then of green, then of blue
uniform int u_size;     // coefficients of a face
uniform int u_first;    // row of the first vector's first term
uniform int u_add;      // whether to add to what is there

shared vec3 shares[VECTORS * LANES][BLOCK];

vec3 light_at(int p)
{
    return vec3(light[3 * p], light[3 * p + 1], light[3 * p + 2]);
}

int place_of(int k)
{
    return int(bitfieldExtract(place[k >> 1], 16 * (k & 1), 16));
}

float step_at(int i)
{
    return float(bitfieldExtract(steps[i >> 2], 8 * (i & 3), 8));
}

void main()
{
    int thread = int(gl_LocalInvocationID.x), mine = thread / LANES, lane = thread % LANES;
    int c = u_terms * u_channels;
    ivec3 channel = u_channels == 1 ? ivec3(0) : u_terms * ivec3(0, 1, 2);
    for (int v = VECTORS * int(gl_WorkGroupID.x); v < u_count; v += VECTORS * int(gl_NumWorkGroups.x)) {
        int r = v + mine;
        for (int first = 0; first < u_terms; first += BLOCK) {
            int many = min(BLOCK, u_terms - first);
            vec3 sum[BLOCK];
            for (int j = 0; j < BLOCK; j++)
                sum[j] = vec3(0.0);
            if (r < u_count)
                for (int k = start[r] + lane; k < start[r + 1]; k += LANES) {
                    vec3 l = light_at(place_of(k));
                    ivec3 i = k * c + first + channel;
                    for (int j = 0; j < many; j++)
                        sum[j] += vec3(step_at(i.x + j), step_at(i.y + j), step_at(i.z + j)) * l;
                }
            for (int j = 0; j < many; j++)
                shares[thread][j] = sum[j];
            barrier();
            if (r < u_count && lane < many) {
                vec3 total = vec3(0.0);
                for (int k = LANES * mine; k < LANES * (mine + 1); k++)
                    total += shares[k][lane];
                ivec3 i = first + lane + channel;
                ivec3 at = r * c + i;
                total *= vec3(scale[at.x], scale[at.y], scale[at.z]);
                for (int f = 0; f < FACES; f++) {
                    at = (FACES * r + f) * c + i;
                    total += vec3(base[at.x], base[at.y], base[at.z]) * light_at(f * u_size);
                }
                int row = u_first + r * u_terms + first + lane;
                for (int q = 0; q < 3; q++)
                    lit[3 * row + q] = total[q] + (u_add == 0 ? 0.0 : lit[3 * row + q]);
            }
            barrier();
        }
    }
}
