// Twin of engine/brdf/wavelet/synthesis.py: values of an encoded BRDF, straight from its block.

#include "common/tangent_poles.glsl"

// What `packed` of engine/brdf/library.py holds; `a` is the word where a block begins, which is as in
// engine/brdf/wavelet/layout.py.
layout(std430) readonly buffer b_library { uint words[]; };

// Places in a block's header, and what they may say.
const int SYMMETRY = 0, THETA_BITS = 1, PHI_BITS = 2, ACROSS = 3, DOWN = 4, CHANNELS = 5;
const int SCHEDULE = 6, ROOT = 7, RANGES = 8, THETA_RATIOS = 9, PHI_RATIOS = 10;
const int THETA_SHARES = 11, PHI_SHARES = 12, MAP = 13, FIRST_ROW = 14, FIRST_TILE = 15, FLOOR = 16;
const int GENERAL = 0, ORTHOTROPIC = 1, ISOTROPIC = 2;
const int TILE = 8;

struct PlaneTaps {
    ivec2 first; // column and row of the first of the four incident directions around one
    vec2 f;      // weights of the second ones
};

int int_at(int a, int k)
{
    return int(words[a + k]);
}

float float_at(int a, int k)
{
    return uintBitsToFloat(words[a + k]);
}

int half_at(int a, int k)
{
    return int(words[a + (k >> 1)] >> (16 * (k & 1)) & 0xffffu);
}

float octet_at(int a, int k)
{
    return float(words[a + (k >> 2)] >> (8 * (k & 3)) & 0xffu);
}

vec3 vector_at(int a, int k)
{
    return vec3(float_at(a, k), float_at(a, k + 1), float_at(a, k + 2));
}

vec3 between(vec3 a, vec3 b, vec3 c, vec3 d, vec2 f)
{
    vec3 upper = a + f.x * (b - a);
    return upper + f.y * (c + f.x * (d - c) - upper);
}

PlaneTaps plane_taps(int a, vec3 w)
{
    vec2 size = vec2(int_at(a, ACROSS), int_at(a, DOWN));
    vec2 uv = tangent_coordinates(w), x = uv * size - 0.5;
    if (int_at(a, SYMMETRY) == ISOTROPIC)
        x = vec2((1.0 - 2.0 * uv.x) * (size.x - 0.5), 0.0);
    x = clamp(x, vec2(0.0), size - 1.0);
    ivec2 first = min(ivec2(x), max(ivec2(0), ivec2(size) - 2));
    return PlaneTaps(first, x - vec2(first));
}

// Mean values over the whole tree, the floor included.
vec3 root_at(int a, PlaneTaps taps)
{
    int across = int_at(a, ACROSS);
    int p = int_at(a, ROOT) + 3 * (taps.first.y * across + taps.first.x);
    int below = int_at(a, DOWN) > 1 ? 3 * across : 0;
    return exp(between(vector_at(a, p), vector_at(a, p + 3), vector_at(a, p + below),
                       vector_at(a, p + below + 3), taps.f));
}

vec3 codes_at(int a, int q, bool grey)
{
    return grey ? vec3(octet_at(a, q)) : vec3(octet_at(a, q), octet_at(a, q + 1), octet_at(a, q + 2));
}

// B / A of a node, by channel: what its second half reflects for each part of its first's.
vec3 odds(int a, int node, int depth, float ratio, PlaneTaps taps)
{
    ivec2 tile = taps.first / TILE, within = taps.first % TILE;
    ivec2 tiles = (ivec2(int_at(a, ACROSS), int_at(a, DOWN)) + TILE - 1) / TILE;
    int row = half_at(a, int_at(a, MAP) + node - 1), number = 0;
    if (row > 0)
        number = half_at(a, int_at(a, FIRST_ROW) + ((row - 1) * tiles.y + tile.y) * tiles.x + tile.x);
    if (number == 0)
        return vec3(ratio);
    int channels = int_at(a, CHANNELS), rows = int_at(a, DOWN) > 1 ? TILE + 1 : 1;
    int start = int_at(a, FIRST_TILE) + (number - 1) * (1 + rows * (TILE + 1) * channels);
    int q = start + 1 + (within.y * (TILE + 1) + within.x) * channels;
    int below = rows > 1 ? (TILE + 1) * channels : 0;
    bool grey = channels == 1;
    vec3 code = between(codes_at(a, q, grey), codes_at(a, q + channels, grey),
                        codes_at(a, q + below, grey), codes_at(a, q + below + channels, grey), taps.f);
    float scale = octet_at(a, start), one = scale * scale * float_at(a, int_at(a, RANGES) + depth);
    return ratio * exp(-one * (code - 128.0));
}

// What the cell reflects that the first splits lead to, on the way to leaf (i, j).
vec3 descended(int a, PlaneTaps taps, ivec2 leaf, int depth)
{
    vec3 reflected = root_at(a, taps);
    int node = 1;
    for (int k = 0; k < depth; k++) {
        int s = int_at(a, SCHEDULE) + 3 * k, angle = int_at(a, s);
        int left = int_at(a, s + 1 + angle), bits = int_at(a, THETA_BITS + angle);
        int interval = (1 << (bits - left - 1)) + (leaf[angle] >> (left + 1));
        int second = leaf[angle] >> left & 1;
        float ratio = float_at(a, int_at(a, THETA_RATIOS + angle) + interval - 1);
        vec3 e = odds(a, node, k, ratio, taps);
        reflected *= (second == 1 ? e : vec3(1.0)) / (1.0 + e);
        node = 2 * node + second;
    }
    return reflected;
}

// BRDF in 1/sr for directions above the surface, at a whole level; 0 is the finest.
// With `nearest` that of the sample and the cell that are nearest.
vec3 synthesise(int a, vec3 wi, vec3 wo, int level, bool nearest)
{
    vec3 plane = wi, tree = wo;
    int symmetry = int_at(a, SYMMETRY);
    if (symmetry == ISOTROPIC) {
        float r = length(wi.xy);
        vec2 x = r > 1e-12 ? wi.xy / r : vec2(1.0, 0.0);
        plane = vec3(r, 0.0, wi.z);
        tree = vec3(dot(x, wo.xy), abs(x.x * wo.y - x.y * wo.x), wo.z);
    } else if (symmetry == ORTHOTROPIC) {
        vec2 side = vec2(wo.x < 0.0 ? -1.0 : 1.0, wo.y < 0.0 ? -1.0 : 1.0);
        plane.xy *= side;
        tree.xy *= side;
    }
    vec2 uv = tangent_coordinates(tree);
    uv *= vec2(symmetry == ORTHOTROPIC ? 2.0 : 1.0, symmetry == GENERAL ? 1.0 : 2.0);
    ivec2 bits = ivec2(int_at(a, THETA_BITS), int_at(a, PHI_BITS)) - level, cells = ivec2(1) << bits;
    vec2 x = uv * vec2(cells) - 0.5;
    if (nearest)
        x = clamp(floor(x + 0.5), vec2(0.0), vec2(cells - 1));
    vec2 low = floor(x), f = x - low;
    vec3 sum = vec3(0.0);
    for (int corner = 0; corner < 4; corner++) {
        ivec2 next = ivec2(corner & 1, corner >> 1), at = ivec2(low) + next;
        vec2 w = mix(1.0 - f, f, vec2(next));
        if (w.x * w.y <= 0.0)
            continue;
        // Beyond an edge lies the mirror image, or nothing.
        vec3 image = plane;
        if (symmetry == ORTHOTROPIC)
            image.xy *= mix(vec2(1.0), vec2(-1.0), equal(at, cells));
        at = clamp(at, ivec2(0), cells - 1);
        PlaneTaps taps = plane_taps(a, image);
        if (nearest)
            taps.f = step(0.5, taps.f);
        vec3 cell = descended(a, taps, at << level, bits.x + bits.y);
        ivec2 interval = cells + at;
        float share = float_at(a, int_at(a, THETA_SHARES) + interval.x)
            * float_at(a, int_at(a, PHI_SHARES) + interval.y);
        sum += w.x * w.y * share * cell;
    }
    return max(sum - vector_at(a, int_at(a, FLOOR)), 0.0);
}
