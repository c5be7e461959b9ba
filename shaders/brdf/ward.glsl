// Twin of engine/brdf/ward.py: Ward 1992, eq. 5a.

#include "brdf/base.glsl"

const float MIN_ALPHA_WARD = 0.02, STEEPEST_WARD = 100.0;

vec3 evaluate_ward(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 value = diffuse_colour(p) / PI;
    float along = max(MIN_ALPHA_WARD, p[6]);
    float across = max(MIN_ALPHA_WARD, along * p[7]);
    // Sum and difference of unit vectors are perpendicular. What float32 rounds off a length is not,
    // and near grazing angles a narrow lobe would show it.
    vec3 sum = wi + wo, apart = wi - wo;
    sum -= apart * (dot(sum, apart) / max(1e-30, dot(apart, apart)));
    vec3 h = to_grain(p, normalize(sum));
    vec2 slope = h.xy / vec2(along, across);
    float r2 = dot(slope, slope), z2 = h.z * h.z;
    if (r2 >= STEEPEST_WARD * z2)
        return value;
    float gloss = exp(-r2 / z2) / (4.0 * PI * along * across * max(1e-30, sqrt(wi.z * wo.z)));
    return value + specular_colour(p) * gloss;
}
