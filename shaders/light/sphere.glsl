// Twin of engine/light/sphere.py.

#include "common/frames.glsl"
#include "common/sampling.glsl"
#include "light/base.glsl"
#include "light/cap.glsl"

Lit illuminate_sphere(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 c = place(p) - x;
    float d2 = dot(c, c), radius2 = p[9] * p[9];
    if (d2 <= radius2)
        return UNLIT;
    float d = sqrt(d2), s2 = radius2 / d2;
    float versine = s2 / (1.0 + sqrt(1.0 - s2));
    vec3 z = c / d, s, t;
    tangents(z, s, t);
    vec3 w = to_world(uniform_cone(u, versine), s, t, z);
    // To the front of the ball; the chord's middle is found first, as its difference has digits.
    float along = dot(c, w);
    vec3 off = c - along * w;
    float h2 = radius2 - dot(off, off);
    float r = h2 < 0.0 ? sqrt(d2 - radius2) : max(0.0, along - sqrt(h2));
    return Lit(w, r, intensity(p) * (2.0 * PI * versine));
}

vec4 emitted_sphere(float p[LIGHT_ROW], vec3 o, vec3 d)
{
    vec3 c = place(p) - o;
    float radius2 = p[9] * p[9], along = dot(c, d);
    vec3 off = c - along * d;
    float h2 = radius2 - dot(off, off);
    if (dot(c, c) <= radius2 || along <= 0.0 || h2 < 0.0)
        return MISSED;
    return vec4(intensity(p), max(0.0, along - sqrt(h2)));
}

vec3 irradiance_sphere(float p[LIGHT_ROW], vec3 x, vec3 n, vec3 g)
{
    vec3 c = place(p) - x;
    float d2 = dot(c, c), radius2 = p[9] * p[9];
    return d2 <= radius2 ? vec3(0.0) : cap_irradiance(p, c / sqrt(d2), radius2 / d2, n, g);
}

#define glance_sphere illuminate_sphere
