// Twin of engine/light/distant.py.

#include "light/base.glsl"

Lit illuminate_distant(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    return Lit(-axis(p), 1e30, intensity(p));
}
