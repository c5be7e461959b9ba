// Warps of the unit square; twins of engine/numerics/sampling.py.

const float PI = 3.14159265358979;

vec2 concentric_disk(vec2 u)
{
    vec2 a = 2.0 * u - 1.0;
    if (a.x == 0.0 && a.y == 0.0)
        return vec2(0.0);
    if (abs(a.x) > abs(a.y)) {
        float phi = 0.25 * PI * a.y / a.x;
        return a.x * vec2(cos(phi), sin(phi));
    }
    float phi = 0.25 * PI * a.x / a.y;
    return a.y * vec2(sin(phi), cos(phi));
}

vec3 uniform_cone(vec2 u, float versine)
{
    vec2 a = concentric_disk(u);
    float drop = versine * dot(a, a);
    return vec3(a * sqrt(versine * (2.0 - drop)), 1.0 - drop);
}
