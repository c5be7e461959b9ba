// Twin of engine/brdf/cook_torrance.py: Cook and Torrance 1982.

#include "brdf/coupled.glsl"

const float MIN_SLOPE = 0.002, STEEPEST = 100.0;

// D, with sin² written as x² + y² so that sharp lobes keep their digits.
float beckmann(float m, vec3 h)
{
    float m2 = m * m, z2 = h.z * h.z;
    float r2 = dot(h.xy, h.xy);
    if (r2 >= STEEPEST * m2 * z2)
        return 0.0;
    return exp(-r2 / (m2 * z2)) / (PI * m2 * z2 * z2);
}

// G / (4 cos θ_i cos θ_o): of the two that block, the lower direction does, and cancels.
float visible_cook_torrance(vec3 h, float cos_d, vec3 wi, vec3 wo)
{
    return min(1.0 / max(1e-30, 4.0 * wi.z * wo.z),
               h.z / max(1e-30, 2.0 * cos_d * max(wi.z, wo.z)));
}

vec3 evaluate_cook_torrance(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    // Half the length: near grazing angles the product of the vectors would have no digits left.
    vec3 h = normalize(wi + wo);
    float cos_d = 0.5 * length(wi + wo);
    float gloss = visible_cook_torrance(h, cos_d, wi, wo) * beckmann(max(MIN_SLOPE, p[6]), h);
    return coupled_base(p, wi, wo) + fresnel(specular_colour(p), cos_d) * gloss;
}
