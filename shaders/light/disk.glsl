// Twin of engine/light/disk.py, which derives the cone and its density.

#include "common/frames.glsl"
#include "common/sampling.glsl"
#include "light/base.glsl"

const float NEAREST = 1e-9;
const float CLOSE = 1.0;

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

vec3 irradiance_disk(float p[LIGHT_ROW], vec3 x, vec3 n, vec3 g)
{
    vec3 m = axis(p), c = place(p) - x;
    float h = -dot(c, m), radius2 = p[9] * p[9];
    if (h < NEAREST)
        return vec3(0.0);
    float facing = dot(n, m), over = dot(g, m), up = dot(n, c), high = dot(g, c);
    float reach = sqrt(radius2 * max(0.0, 1.0 - facing * facing));
    float wide = sqrt(radius2 * max(0.0, 1.0 - over * over));
    if (up <= -reach || high <= -wide)
        return vec3(0.0);
    if (up < reach || high < wide)
        return UNKNOWN;
    vec3 foot = c + h * m;
    float h2 = h * h, a2 = dot(foot, foot), total = a2 + h2 + radius2, q = h2 + radius2 - a2;
    float s = sqrt(q * q + 4.0 * a2 * h2);
    float down = q > 0.0 ? q + s : 4.0 * a2 * h2 / (s - q);
    return intensity(p) * (PI * radius2 / (s * (total + s)) * (2.0 * h * dot(n, foot) - down * facing));
}

Lit glance_disk(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    vec2 a = concentric_disk(u) * p[9];
    vec3 d = place(p) - x + a.x * vec3(p[10], p[11], p[12]) + a.y * vec3(p[13], p[14], p[15]);
    float h = -dot(d, axis(p)), r2 = dot(d, d), r = sqrt(r2);
    if (h < CLOSE * p[9])
        return illuminate_disk(p, x, size, u);
    return Lit(d / r, r, intensity(p) * (PI * p[9] * p[9] * h / (r * r2)));
}
