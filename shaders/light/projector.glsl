// Twin of engine/light/projector.py.

#include "light/base.glsl"
#include "light/pyramid.glsl"

Lit illuminate_projector(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 d = x - place(p);
    float z = dot(d, axis(p)), r2 = dot(d, d);
    if (z <= 0.0 || r2 < 1e-20)
        return UNLIT;
    float r = sqrt(r2);
    vec3 w = -d / r, left = vec3(p[9], p[10], p[11]), up = vec3(p[12], p[13], p[14]);
    vec2 uv = 0.5 - 0.5 * vec2(dot(d, left), dot(d, up)) / (z * vec2(p[15], p[16]));
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0))))
        return Lit(w, r, vec3(0.0));
    float wide = size / (z * p[17]);
    float lod = wide > 1.0 ? log2(wide) : 0.0;
    vec3 colour = look_up(vec3(p[29], p[30], p[31]), uv, lod);
    return Lit(w, r, intensity(p) * colour * (r / (z * z * z)));
}
