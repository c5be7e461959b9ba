// Twin of engine/brdf/ashikhmin_shirley.py: Ashikhmin and Shirley 2000, eq. 4, 5.

#include "brdf/base.glsl"
#include "brdf/fresnel.glsl"
#include "common/power.glsl"

// What either direction, at the cosine c, contributes to the base: 1 - (1 - c / 2)^5.
float base_ashikhmin_shirley(float c)
{
    float x = 1.0 - 0.5 * c, x2 = x * x;
    return 1.0 - x2 * x2 * x;
}

vec3 evaluate_ashikhmin_shirley(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 f0 = specular_colour(p);
    float matt = 28.0 / (23.0 * PI) * base_ashikhmin_shirley(wi.z) * base_ashikhmin_shirley(wo.z);
    vec3 value = diffuse_colour(p) * (1.0 - f0) * matt;
    // Half the length: near grazing angles the product of the vectors would have no digits left.
    vec3 h = normalize(wi + wo);
    float cos_d = 0.5 * length(wi + wo);
    if (cos_d <= 1e-12)
        return value;
    vec3 g = to_grain(p, h);
    float x = g.x * g.x, y = g.y * g.y, nu = p[6], nv = p[7];
    float e = x + y > 0.0 ? (nu * x + nv * y) / (x + y) : 0.0;
    float density = sqrt((nu + 1.0) * (nv + 1.0)) / (2.0 * PI) * lobe(h, vec3(0.0, 0.0, 1.0), e);
    return value + fresnel(f0, cos_d) * (density / (4.0 * max(1e-30, cos_d * max(wi.z, wo.z))));
}
