// Twin of engine/brdf/fresnel.py: Schlick 1994, eq. 15.

float f90(vec3 f0)
{
    return min(1.0, 50.0 * max(f0.x, max(f0.y, f0.z)));
}

vec3 fresnel(vec3 f0, float cosine)
{
    float c = 1.0 - clamp(cosine, 0.0, 1.0);
    float w = c * c * c * c * c;
    return f0 * (1.0 - w) + f90(f0) * w;
}
