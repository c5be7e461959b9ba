// Twin of engine/brdf/diffuse.py.

#include "brdf/base.glsl"

vec3 evaluate_diffuse(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    return diffuse_colour(p) / PI;
}
