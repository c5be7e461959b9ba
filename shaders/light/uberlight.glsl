// Twin of engine/light/uberlight.py: Barzel 1997.

#include "common/power.glsl"
#include "light/base.glsl"

const float BRIGHTEST = 1e20;

// 0 up to a, 1 from b, in between 3s² - 2s³.
float smooth_step(float a, float b, float t)
{
    if (t <= a)
        return 0.0;
    if (t >= b)
        return 1.0;
    float s = (t - a) / (b - a);
    return s * s * (3.0 - 2.0 * s);
}

// 1 in the inner superellipse, 0 outside the outer one; power 0 is a rectangle.
float inside(vec2 at, vec2 half_size, float edge, float m)
{
    at = abs(at);
    if (m == 0.0)
        return (1.0 - smooth_step(half_size.x, half_size.x + edge, at.x))
            * (1.0 - smooth_step(half_size.y, half_size.y + edge, at.y));
    if (at.x <= 0.5 * half_size.x && at.y <= 0.5 * half_size.y)
        return 1.0;
    vec2 outer = half_size + edge;
    if (at.x >= outer.x || at.y >= outer.y)
        return 0.0;
    vec2 q = at / half_size;
    float inner = power(power(q.x, m) + power(q.y, m), -1.0 / m);
    if (inner >= 1.0)
        return 1.0;
    q = at / outer;
    return 1.0 - smooth_step(inner, power(power(q.x, m) + power(q.y, m), -1.0 / m), 1.0);
}

// (d / r)^n, bent over below d so that it stays under e^s.
float falloff(float r, float n, float d, float s)
{
    float t = r / d;
    if (t >= 1.0 || n == 0.0 || s == 0.0)
        return min(power(t, -n), BRIGHTEST);
    return exp(s - s * power(t, n / s));
}

Lit illuminate_uberlight(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 d = x - place(p), left = vec3(p[9], p[10], p[11]);
    float z = dot(d, axis(p));
    if (z < 1e-10 || z <= p[16] || z >= p[19])
        return UNLIT;
    // Right and up across the axis.
    vec2 at = vec2(-dot(d, left), dot(d, cross(axis(p), left)));
    bool parallel = p[24] > 0.0;
    float r = parallel ? z : length(d);
    vec3 w = parallel ? -axis(p) : -d / r;
    float cosine = parallel ? 1.0 : z / r;
    float k = inside(parallel ? at : at / z, vec2(p[12], p[13]), p[14], p[15]);
    k *= smooth_step(p[16], p[17], z) * (1.0 - smooth_step(p[18], p[19], z));
    if (k <= 0.0)
        return Lit(w, r, vec3(0.0));
    k *= falloff(r, p[20], p[21], p[22]) * power(cosine, p[23]);
    if (p[25] > 0.0 && z > p[25]) {
        vec2 through = parallel ? at : at * (p[25] / z);
        k *= 1.0 - inside(through - vec2(p[26], p[27]), vec2(p[28], p[29]), p[30], 0.0);
    }
    return Lit(w, r, intensity(p) * k);
}
