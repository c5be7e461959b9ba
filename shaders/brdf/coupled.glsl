// Twin of engine/brdf/coupled.py: Shirley et al. 1997, §5.

#include "brdf/base.glsl"
#include "brdf/fresnel.glsl"

vec3 coupled_base(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    vec3 f0 = specular_colour(p);
    // It vanishes where the interface lets nothing through.
    vec3 passed = (1.0 - fresnel(f0, wi.z)) * (1.0 - fresnel(f0, wo.z));
    vec3 mean = max(vec3(1e-9), 1.0 - f0 - (f90(f0) - f0) / 21.0);
    return diffuse_colour(p) * passed / (PI * mean);
}
