// Twin of engine/light/spot.py.

#include "light/base.glsl"

Lit illuminate_spot(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 d = place(p) - x;
    float r2 = dot(d, d);
    if (r2 < 1e-20)
        return UNLIT;
    float r = sqrt(r2);
    vec3 w = d / r;
    // 1 - cos of the angle to the axis is half the squared distance between the unit vectors.
    vec3 a = axis(p) + w;
    float versine = 0.5 * dot(a, a), outer = p[9], inner = p[10];
    float falloff = 0.0;
    if (versine <= inner)
        falloff = 1.0;
    else if (versine < outer) {
        float s = (outer - versine) / (outer - inner);
        falloff = s * s * (3.0 - 2.0 * s);
    }
    return Lit(w, r, intensity(p) * (falloff / r2));
}
