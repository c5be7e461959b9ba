// Twin of engine/light/point.py.

#include "light/base.glsl"

Lit illuminate_point(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 d = place(p) - x;
    float r2 = dot(d, d);
    if (r2 < 1e-20)
        return UNLIT;
    float r = sqrt(r2);
    return Lit(d / r, r, intensity(p) / r2);
}
