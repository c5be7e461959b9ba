// Twin of engine/brdf/phong.py: Lafortune and Willems 1994, eq. 3.

#include "brdf/base.glsl"
#include "common/power.glsl"

vec3 evaluate_phong(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 value = diffuse_colour(p) / PI;
    vec3 mirror = vec3(-wo.xy, wo.z);
    if (dot(mirror, wi) > 0.0)
        value += specular_colour(p) * ((p[6] + 2.0) / (2.0 * PI) * lobe(mirror, wi, p[6]));
    return value;
}
