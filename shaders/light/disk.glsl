// Twin of engine/light/disk.py, which derives the cone and its density.

#include "common/frames.glsl"
#include "common/sampling.glsl"
#include "light/base.glsl"

const float NEAREST = 1e-9;

// f = 1 - √(k / (1 + k)), with its digits for large k too.
float height(float k)
{
    return 1.0 / ((1.0 + k) * (1.0 + sqrt(k / (1.0 + k))));
}

Lit illuminate_disk(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec3 n = axis(p), c = place(p) - x;
    float h = -dot(c, n), radius = p[9];
    if (h < NEAREST)
        return UNLIT;
    // Across the disk's axis, from x's foot to the centre.
    vec3 e = c + h * n, other;
    float a = length(e);
    if (a > 1e-6 * (h + radius))
        e /= a;
    else {
        tangents(n, e, other);
        a = 0.0;
    }
    // 1/α² and 1/β² of the cone: half-angle formulas, in which nothing cancels.
    float near = length(vec2(a - radius, h)), far = length(vec2(a + radius, h));
    float q = a * a + h * h - radius * radius, y = 2.0 * radius * h;
    float sum = q > 0.0 ? q + near * far : y * y / (near * far - q);
    float ia = (sum / y) * (sum / y), ib = sum / (2.0 * radius * radius);
    vec2 down = normalize(vec2((a - radius) / near + (a + radius) / far, h / near + h / far));
    vec3 ez = down.x * e - down.y * n, ex = down.y * e + down.x * n, ey = cross(ez, ex);

    vec2 d = concentric_disk(u);
    float v = dot(d, d), fa = height(ia), fb = height(ib), kappa = sqrt(fb / fa);
    d.y *= kappa;
    float r2 = dot(d, d), cosine2 = r2 > 0.0 ? d.x * d.x / r2 : 1.0;
    float f = height(cosine2 * ia + (1.0 - cosine2) * ib);
    float drop = v * f;
    float s = sqrt(drop * (2.0 - drop)) * (r2 > 0.0 ? inversesqrt(r2) : 1.0);
    vec3 w = s * (d.x * ex + d.y * ey) + (1.0 - drop) * ez;
    float facing = -dot(w, n);
    if (facing <= 0.0)
        return UNLIT;
    float turn = kappa / (kappa * kappa * cosine2 + 1.0 - cosine2);
    return Lit(w, h / facing, intensity(p) * (2.0 * PI * f / turn));
}

vec4 emitted_disk(float p[LIGHT_ROW], vec3 o, vec3 d)
{
    vec3 c = o - place(p);
    float facing = -dot(d, axis(p)), t = dot(c, axis(p)) / facing;
    vec3 hit = c + t * d;
    return facing > 0.0 && t > 0.0 && dot(hit, hit) <= p[9] * p[9] ? vec4(intensity(p), t) : MISSED;
}
