// Twin of engine/brdf/blinn_phong.py: Blinn 1977, with the factor of Giesen 2009.

#include "brdf/base.glsl"
#include "common/power.glsl"

float normalisation(float n)
{
    return (n + 2.0) * (n + 4.0) / (8.0 * PI * (power(2.0, -0.5 * n) + n));
}

vec3 evaluate_blinn_phong(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float n = p[6];
    float mirrored = lobe(normalize(wi + wo), vec3(0.0, 0.0, 1.0), n);
    return diffuse_colour(p) / PI + specular_colour(p) * (normalisation(n) * mirrored);
}
