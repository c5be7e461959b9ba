// The BRDF contract, as in engine/brdf/base.py: local directions, z the normal, no cosine.

#include "common/sampling.glsl"

const int BRDF_ROW = 36;

vec3 diffuse_colour(float p[BRDF_ROW])
{
    return vec3(p[0], p[1], p[2]);
}

vec3 specular_colour(float p[BRDF_ROW])
{
    return vec3(p[3], p[4], p[5]);
}

// The local direction w in the frame whose x axis runs along the grain of an anisotropic row.
vec3 to_grain(float p[BRDF_ROW], vec3 w)
{
    return vec3(p[34] * w.x + p[35] * w.y, p[34] * w.y - p[35] * w.x, w.z);
}
