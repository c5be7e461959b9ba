// Twin of engine/brdf/half_angle_curve.py: facets whose distribution is a curve of points.

#include "brdf/cook_torrance.glsl"

const int BANDS = 21;

// D, with 1 - cos θ_h from x² + y² so that small angles keep their digits.
float distribution_curve(float p[BRDF_ROW], vec3 h)
{
    float x = float(BANDS) * sqrt(sqrt(dot(h.xy, h.xy) / (1.0 + h.z)));
    int k = min(int(x), BANDS - 1);
    return mix(p[7 + k], p[8 + k], x - float(k)) / PI;
}

vec3 evaluate_half_angle_curve(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    // Half the length: near grazing angles the product of the vectors would have no digits left.
    vec3 h = normalize(wi + wo);
    float cos_d = 0.5 * length(wi + wo);
    float gloss = visible_cook_torrance(h, cos_d, wi, wo) * distribution_curve(p, h);
    return coupled_base(p, wi, wo) + fresnel(specular_colour(p), cos_d) * gloss;
}
