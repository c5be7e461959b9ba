// The BRDF contract, as in engine/brdf/base.py: local directions, z the normal, no cosine.

#include "common/sampling.glsl"

const int BRDF_ROW = 16;

vec3 diffuse_colour(float p[BRDF_ROW])
{
    return vec3(p[0], p[1], p[2]);
}

vec3 specular_colour(float p[BRDF_ROW])
{
    return vec3(p[3], p[4], p[5]);
}
