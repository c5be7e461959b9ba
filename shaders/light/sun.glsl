// Twin of engine/light/sun.py.

#include "common/frames.glsl"
#include "common/sampling.glsl"
#include "light/base.glsl"
#include "light/cap.glsl"

Lit illuminate_sun(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 z = -axis(p), s, t;
    tangents(z, s, t);
    vec3 w = to_world(uniform_cone(u, p[9]), s, t, z);
    return Lit(w, 1e30, intensity(p) * (2.0 * PI * p[9]));
}

vec4 emitted_sun(float p[LIGHT_ROW], vec3 o, vec3 d)
{
    // 1 - cos is half the squared distance of unit vectors.
    vec3 a = axis(p) + d;
    return 0.5 * dot(a, a) <= p[9] ? vec4(intensity(p), 1e30) : MISSED;
}

vec3 irradiance_sun(float p[LIGHT_ROW], vec3 x, vec3 n, vec3 g)
{
    return cap_irradiance(p, -axis(p), p[9] * (2.0 - p[9]), n, g);
}

#define glance_sun illuminate_sun
