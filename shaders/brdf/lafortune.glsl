// Twin of engine/brdf/lafortune.py: Lafortune et al. 1997, eq. 6.

#include "brdf/base.glsl"
#include "common/power.glsl"

// (C_xy (wi_x wo_x + wi_y wo_y) + C_z wi_z wo_z)^n as |V|^n times a power of the cosine between the
// unit vectors, which keeps the digits of sharp lobes.
float lobe_lafortune(float xy, float z, float n, vec3 wi, vec3 wo)
{
    vec3 v = vec3(xy * wo.xy, z * wo.z);
    float more = (xy * xy - 1.0) * dot(wo.xy, wo.xy) + (z * z - 1.0) * wo.z * wo.z; // |V|² - 1
    if (dot(v, wi) <= 0.0)
        return 0.0;
    float size = abs(more) < 0.3 ? exp2(0.5 * n * log1p_near_zero(more) * 1.44269504)
                                 : power(length(v), n);
    return size * lobe(normalize(v), wi, n);
}

vec3 evaluate_lafortune(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 gloss = vec3(0.0);
    for (int k = 6; k < 33; k += 9)
        for (int c = 0; c < 3; c++)
            gloss[c] += lobe_lafortune(p[k + c], p[k + 3 + c], p[k + 6 + c], wi, wo);
    return diffuse_colour(p) / PI + specular_colour(p) * gloss;
}
