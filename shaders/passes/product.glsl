// Packed rows times a light in wavelet space; twin of engine/backend/cpu/product.py.
//
// A work group takes a tile. Four steps lie together in a word. A wavelet has WORDS_0 words, WORDS_1,
// WORDS_2 or none, in units UNIT_2, UNIT_1, UNIT_0 (engine/numerics/packed.py); for each kind the
// threads share the wavelets among them, as many as it has words side by side, and in the end the
// shares are added.

layout(local_size_x = TILE) in;

layout(std430) readonly buffer b_first { int first[]; };     // (tiles, 3) of the list, its words, its scales
layout(std430) readonly buffer b_length { int length_of[]; }; // (tiles, 4) wavelets of each kind
layout(std430) readonly buffer b_ids { int ids[]; };         // (q)
layout(std430) readonly buffer b_mean { float mean[]; };     // (q)
layout(std430) readonly buffer b_scale { float scale[]; };   // (s) of wavelets that have words
layout(std430) readonly buffer b_steps { uint steps[]; };    // four signed bytes each
layout(std430) readonly buffer b_light { float light[]; };   // (n_g, 3)
layout(std430) readonly buffer b_places { int places[]; };   // (tiles, u_rows) -1 for none
layout(std430) writeonly buffer b_out { float result[]; };   // (n, 3)

uniform int u_tiles;
uniform int u_rows; // 64, or 16 for every fourth

struct Sums {
    vec4 red, green, blue;
};

shared vec3 lit[TILE]; // scale times light of the wavelets at hand
shared vec4 shares[3][TILE];
shared float sums[3][TILE];

int thread = int(gl_LocalInvocationID.x);

// Add wavelets k to end, which have so many words from `word` on; those at hand begin with `start`.
void add(inout Sums s, int start, int k, int end, int words, int word)
{
    int skipped = max(0, start - k);
    for (int j = k + skipped + thread / words; j < min(end, start + TILE); j += TILE / words) {
        int four = int(steps[word + (j - k) * words + thread % words]);
        vec4 value = vec4(bitfieldExtract(four, 0, 8), bitfieldExtract(four, 8, 8),
                          bitfieldExtract(four, 16, 8), bitfieldExtract(four, 24, 8));
        vec3 l = lit[j - start];
        s.red += value * l.x;
        s.green += value * l.y;
        s.blue += value * l.z;
    }
}

// Add the shares of all threads to the sums of the first steps.
void collect(Sums s, int words)
{
    shares[0][thread] = s.red;
    shares[1][thread] = s.green;
    shares[2][thread] = s.blue;
    barrier();
    if (thread < 4 * words)
        for (int c = 0; c < 3; c++)
            for (int k = thread / 4; k < TILE; k += words)
                sums[c][thread] += shares[c][k][thread % 4];
    barrier();
}

// The value of a child (0 to 3) of a node, of its scaling coefficient and three details.
float child(int number, float s, float h, float v, float d)
{
    h = (number & 1) == 0 ? h : -h;
    v = (number & 2) == 0 ? v : -v;
    d = number == 0 || number == 3 ? d : -d;
    return 0.5 * (s + h + v + d);
}

void main()
{
    // The same number of rounds for all threads of a group keeps the barriers in step.
    for (int t = int(gl_WorkGroupID.x); t < u_tiles; t += int(gl_NumWorkGroups.x)) {
        const Sums NONE = Sums(vec4(0.0), vec4(0.0), vec4(0.0));
        Sums of16 = NONE, of4 = NONE, of1 = NONE, means = NONE;
        int k16 = first[3 * t], w16 = first[3 * t + 1];
        int k4 = k16 + length_of[4 * t], w4 = w16 + WORDS_0 * (k4 - k16);
        int k1 = k4 + length_of[4 * t + 1], w1 = w4 + WORDS_1 * (k1 - k4);
        int k0 = k1 + length_of[4 * t + 2], end = k0 + length_of[4 * t + 3];
        for (int start = k16; start < end; start += TILE) {
            barrier(); // the last lights have been used
            int mine = start + thread;
            if (mine < end) {
                // Each is fetched by one thread for all.
                int id = 3 * ids[mine];
                vec3 l = vec3(light[id], light[id + 1], light[id + 2]);
                if (mine < k0)
                    lit[thread] = scale[first[3 * t + 2] + mine - k16] * l;
                means.red.x += mean[mine] * l.x;
                means.green.x += mean[mine] * l.y;
                means.blue.x += mean[mine] * l.z;
            }
            barrier();
            add(of16, start, k16, k4, WORDS_0, w16);
            add(of4, start, k4, k1, WORDS_1, w4);
            add(of1, start, k1, k0, WORDS_2, w1);
        }
        for (int c = 0; c < 3; c++)
            sums[c][thread] = 0.0;
        barrier();
        of1.red += means.red;
        of1.green += means.green;
        of1.blue += means.blue;
        collect(of16, WORDS_0);
        collect(of4, WORDS_1);
        collect(of1, WORDS_2);

        // From what the tile has in common to its rows, by the inverse Haar transform.
        if (thread < u_rows) {
            int place = places[u_rows * t + thread], row = thread * (TILE / u_rows);
            for (int c = 0; c < 3 && place >= 0; c++) {
                // A step stands for the square root of the number of rows that it covers.
                float s = UNIT_0 * sums[c][0];
                s = child(row >> 4, s, UNIT_0 * sums[c][1], UNIT_0 * sums[c][2], UNIT_0 * sums[c][3]);
                int k = 4 + 3 * (row >> 4);
                s = child(row >> 2 & 3, s, UNIT_1 * sums[c][k], UNIT_1 * sums[c][k + 1], UNIT_1 * sums[c][k + 2]);
                k = 16 + 3 * (row >> 2);
                s = child(row & 3, s, UNIT_2 * sums[c][k], UNIT_2 * sums[c][k + 1], UNIT_2 * sums[c][k + 2]);
                result[3 * place + c] = s;
            }
        }
        barrier();
    }
}
