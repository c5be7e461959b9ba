// Twin of engine/brdf/ggx.py, which says where the formulas are from.

#include "brdf/coupled.glsl"

const float MIN_ALPHA = 0.002;

// D, with 1 - cos² written as x² + y² so that sharp lobes keep their digits.
float distribution(float alpha, vec3 h)
{
    float a2 = alpha * alpha;
    float t = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return a2 / (PI * t * t);
}

// cos θ √(1 + α² tan² θ).
float stretched(float alpha, float c)
{
    float a2 = alpha * alpha;
    return sqrt(a2 + (1.0 - a2) * c * c);
}

vec3 evaluate_ggx(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float alpha = max(MIN_ALPHA, p[6] * p[6]);
    vec3 f0 = specular_colour(p);
    float visible = 0.5 / max(1e-30, wo.z * stretched(alpha, wi.z) + wi.z * stretched(alpha, wo.z));
    vec3 h = normalize(wi + wo);
    return coupled_base(p, wi, wo) + fresnel(f0, dot(wo, h)) * (visible * distribution(alpha, h));
}
