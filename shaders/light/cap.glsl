// Twin of engine/light/cap.py: the irradiance of a cone of even radiance.

#include "common/angles.glsl"
#include "light/base.glsl"

vec3 cap_irradiance(float p[LIGHT_ROW], vec3 axis, float sine2, vec3 n, vec3 g)
{
    float cosine = dot(n, axis), over = dot(g, axis);
    if (min(cosine * abs(cosine), over * abs(over)) <= -sine2)
        return vec3(0.0);
    if (over * abs(over) < sine2 && !shares_plane(n, g))
        return UNKNOWN;
    float e = PI * sine2 * cosine;
    if (cosine * abs(cosine) < sine2) {
        float c = sqrt(1.0 - sine2), w = sqrt(sine2 - cosine * cosine);
        e = sine2 * cosine * angle(w, -cosine * c) - w * c + angle(w, c);
    }
    return intensity(p) * e;
}
