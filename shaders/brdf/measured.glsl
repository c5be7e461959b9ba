// Twin of engine/brdf/measured.py, and of engine/brdf/library.py: blocks are filed under keys.

#include "brdf/base.glsl"
#include "brdf/wavelet.glsl"

// Where the block begins that is filed under a key; -1 where there is none.
int find_block(float high, float low)
{
    for (uint k = 1u; k <= 3u * words[0]; k += 3u)
        if (uintBitsToFloat(words[k]) == high && uintBitsToFloat(words[k + 1u]) == low)
            return int(words[k + 2u]);
    return -1;
}

vec3 evaluate_measured(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    int a = find_block(p[7], p[8]);
    if (wi.z <= 0.0 || wo.z <= 0.0 || a < 0)
        return vec3(0.0);
    if (p[34] != 0.0 || p[35] != 0.0) {
        wi = to_grain(p, wi);
        wo = to_grain(p, wo);
    }
    int coarsest = min(int_at(a, THETA_BITS), int_at(a, PHI_BITS)) - 1;
    int level = min(int(p[9]), coarsest);
    bool nearest = p[10] != 0.0;
    vec3 f = synthesise(a, wi, wo, level, nearest);
    float part = p[9] - float(level);
    if (part > 0.0 && level < coarsest)
        f = mix(f, synthesise(a, wi, wo, level + 1, nearest), part);
    return specular_colour(p) * f;
}
