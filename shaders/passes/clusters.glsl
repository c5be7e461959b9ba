// Transport vectors of the clusters of one material times a light; twin of `_add_clusters` of
// engine/backend/cpu/vectors.py.
//
// A work group takes a cluster: its threads first share the components of the basis, then the
// vertices, which lie one behind the other: neighbours read neighbours.

layout(local_size_x = 64) in;

struct Cluster { int vertices, rank, length, first, place, basis, scale, weights; };

layout(std430) readonly buffer b_clusters { Cluster clusters[]; };
layout(std430) readonly buffer b_place { uint place[]; };    // (Σ p) two to a word
layout(std430) readonly buffer b_unit { float unit[]; };     // (Σ p)
layout(std430) readonly buffer b_basis { int basis[]; };     // (Σ p m) signed bytes, four to a word
layout(std430) readonly buffer b_scale { float scale[]; };   // (Σ m, c)
layout(std430) readonly buffer b_weights { int weights[]; }; // (Σ c m n) signed bytes
layout(std430) readonly buffer b_light { float light[]; };   // (texels, 3)
layout(std430) buffer b_lit { float lit[]; };                // (rows, 3)

uniform int u_count;    // clusters
uniform int u_terms;    // K
uniform int u_channels; // 1, or 3: the terms of red, then of green, then of blue
uniform int u_first;    // row of the first vertex's first term
uniform int u_add;      // whether to add to what is there

shared vec3 seen[RANK]; // what each component makes of the light

float step_of(int word, int i)
{
    return float(bitfieldExtract(word, 8 * (i & 3), 8));
}

void main()
{
    int lane = int(gl_LocalInvocationID.x), c = u_terms * u_channels;
    for (int s = int(gl_WorkGroupID.x); s < u_count; s += int(gl_NumWorkGroups.x)) {
        Cluster k = clusters[s];
        for (int j = lane; j < k.rank; j += 64) {
            vec3 sum = vec3(0.0);
            for (int i = 0; i < k.length; i++) {
                int entry = k.place + i, at = k.basis + i * k.rank + j;
                int p = int(bitfieldExtract(place[entry >> 1], 16 * (entry & 1), 16));
                vec3 l = unit[entry] * vec3(light[3 * p], light[3 * p + 1], light[3 * p + 2]);
                sum += step_of(basis[at >> 2], at) * l;
            }
            seen[j] = sum;
        }
        barrier();
        for (int task = lane; task < k.vertices * u_terms; task += 64) {
            int v = task % k.vertices, term = task / k.vertices;
            int row = u_first + (k.first + v) * u_terms + term;
            for (int q = 0; q < 3; q++) {
                int channel = term + (u_channels == 1 ? 0 : q * u_terms);
                float sum = u_add == 0 ? 0.0 : lit[3 * row + q];
                for (int j = 0; j < k.rank; j++) {
                    int at = k.weights + (channel * k.rank + j) * k.vertices + v;
                    sum += step_of(weights[at >> 2], at) * scale[(k.scale + j) * c + channel] * seen[j][q];
                }
                lit[3 * row + q] = sum;
            }
        }
        barrier();
    }
}
