// Packed rows times a light in wavelet space; twin of engine/backend/cpu/product.py.
//
// A work group takes a tile. Its threads share the wavelets among them, those of one share take four
// rows each, which lie together in a word; in the end the shares are added.

layout(local_size_x = 64) in;

layout(std430) readonly buffer b_first { int first[]; };     // (tiles + 1) where each list begins
layout(std430) readonly buffer b_ids { int ids[]; };         // (q)
layout(std430) readonly buffer b_scale { float scale[]; };   // (q)
layout(std430) readonly buffer b_steps { uint steps[]; };    // (q, 16) four signed bytes each
layout(std430) readonly buffer b_light { float light[]; };   // (n_g, 3)
layout(std430) readonly buffer b_places { int places[]; };   // (tiles, ROWS) -1 for none
layout(std430) writeonly buffer b_out { float result[]; };   // (n, 3)

uniform int u_tiles;

// ROWS is 64, or 16 for the first quarter of every tile.
const int WORDS = ROWS / 4, SHARES = 64 / WORDS;
shared vec4 sums[3][64];
shared vec3 lit[64]; // scale times light of the wavelets at hand

void main()
{
    int thread = int(gl_LocalInvocationID.x), word = thread % WORDS, share = thread / WORDS;
    // The same number of rounds for all threads of all groups keeps the barriers in step.
    for (int t = int(gl_WorkGroupID.x); t < u_tiles; t += int(gl_NumWorkGroups.x)) {
        vec4 red = vec4(0.0), green = vec4(0.0), blue = vec4(0.0);
        int end = first[t + 1];
        for (int start = first[t]; start < end; start += 64) {
            barrier(); // the last lights have been used
            int mine = start + thread;
            if (mine < end) {
                int id = 3 * ids[mine];
                // Each is fetched by one thread for all.
                lit[thread] = scale[mine] * vec3(light[id], light[id + 1], light[id + 2]);
            }
            barrier();
            for (int k = share; k < min(64, end - start); k += SHARES) {
                int four = int(steps[16 * (start + k) + word]);
                vec4 value = vec4(bitfieldExtract(four, 0, 8), bitfieldExtract(four, 8, 8),
                                  bitfieldExtract(four, 16, 8), bitfieldExtract(four, 24, 8));
                red += value * lit[k].x;
                green += value * lit[k].y;
                blue += value * lit[k].z;
            }
        }
        sums[0][thread] = red;
        sums[1][thread] = green;
        sums[2][thread] = blue;
        barrier();
        for (int p = thread; p < ROWS; p += 64) {
            int place = places[ROWS * t + p];
            for (int c = 0; c < 3 && place >= 0; c++) {
                float sum = 0.0;
                for (int s = 0; s < SHARES; s++)
                    sum += sums[c][s * WORDS + p / 4][p % 4];
                result[3 * place + c] = sum;
            }
        }
        barrier();
    }
}
