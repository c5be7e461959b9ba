// Twin of engine/light/area.py: even over the solid angle of the rectangle (Ureña, Fajardo, King
// 2013), from far away over its area.

#include "common/angles.glsl"
#include "common/sampling.glsl"
#include "light/base.glsl"

const float NEAREST = 1e-9;
const float CLOSE = 0.75;
const float FAR = 2.5;
const float VERY_FAR = 4.0;
const float SMALL = 1e-6;

// Solid angle of a triangle by its three corners and their triple product (Van Oosterom and
// Strackee 1983). The sum of angles that the twin takes would lose its digits in float32.
float triangle_solid(vec3 a, vec3 b, vec3 c, float product)
{
    float ra = length(a), rb = length(b), rc = length(c);
    float below = ra * rb * rc + dot(a, b) * rc + dot(b, c) * ra + dot(c, a) * rb;
    return 2.0 * atan(product, below);
}

// (cos g, sin g) of the angle between two sides of the spherical rectangle, cos g = x y / (|x, z|
// |y, z|): the acos of a driver may be 1e-3 off.
vec2 inner_angle(vec2 corner, float z)
{
    float x = corner.x, y = corner.y;
    return vec2(x * y, z * length(vec3(corner, z))) / (length(vec2(x, z)) * length(vec2(y, z)));
}

// The unit vector a turned back by the angle of b.
vec2 turned_back(vec2 a, vec2 b)
{
    return vec2(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y);
}

// Even over the solid angle, from `far` diagonals on over the area.
Lit shine(float p[LIGHT_ROW], vec3 x, vec2 u, float far)
{
    vec3 along = vec3(p[9], p[10], p[11]), up = vec3(p[12], p[13], p[14]), c = place(p) - x;
    vec2 middle = vec2(dot(c, along), dot(c, up)), half_size = vec2(p[15], p[16]);
    float z = -dot(c, axis(p));
    if (z < NEAREST)
        return UNLIT;
    vec2 low = middle - half_size, high = middle + half_size, wide = 2.0 * half_size;
    float solid = 0.0;
    if (dot(middle, middle) + z * z <= far * far * dot(wide, wide)) {
        float product = z * wide.x * wide.y;
        vec3 first = vec3(low, z), last = vec3(high, z);
        solid = triangle_solid(first, vec3(high.x, low.y, z), last, product)
            + triangle_solid(first, last, vec3(low.x, high.y, z), product);
    }
    vec2 at = mix(low, high, u);
    float weight = solid;
    if (solid > SMALL) {
        // The column: its part of the solid angle grows evenly with u.x (ibid., §4.1).
        vec2 y = vec2(low.y, high.y), n = sqrt(z * z + y * y);
        float b0 = -y.x / n.x, b1 = y.y / n.y;
        vec2 g2 = inner_angle(vec2(low.x, high.y), z), g3 = inner_angle(vec2(-low.x, low.y), z);
        // φ = u.x · solid + 2π - g2 - g3, as cosine and sine.
        vec2 phi = turned_back(turned_back(vec2(cos(u.x * solid), sin(u.x * solid)), g2), g3);
        float f = phi.x * b0 - b1, s = phi.y;
        // t / √(1 - t²) for the twin's c = t: with 1 - b0² = z² / n.x² nothing but f² - ... cancels.
        float e = z / n.x * s, below = sqrt(max(1e-30, (f - e) * (f + e)));
        at.x = clamp(z * abs(s) / below * (s * f < 0.0 ? -1.0 : 1.0), low.x, high.x);
        // The height in it: the sine of its elevation grows evenly with u.y (ibid., §4.2).
        float d2 = at.x * at.x + z * z;
        float h0 = low.y * inversesqrt(d2 + low.y * low.y);
        float h1 = high.y * inversesqrt(d2 + high.y * high.y);
        float h = mix(h0, h1, u.y);
        at.y = clamp(h * sqrt(d2 / max(1e-30, 1.0 - h * h)), low.y, high.y);
    }
    float r = length(vec3(at, z));
    if (solid <= SMALL)
        weight = p[17] * z / (r * r * r);
    vec3 w = (at.x * along + at.y * up - z * axis(p)) / r;
    return Lit(w, r, intensity(p) * weight);
}

Lit illuminate_area(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    return shine(p, x, u, FAR);
}

Lit glance_area(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
{
    return shine(p, x, u, CLOSE);
}

// ½ n · (a × b) / |a × b| · angle of a and b.
float side(vec3 a, vec3 b, vec3 n)
{
    float i = 1.0 / (length(a) * length(b));
    return 0.5 * i * dot(n, cross(a, b)) * angle_over_sine(dot(a, b) * i);
}

vec3 irradiance_area(float p[LIGHT_ROW], vec3 x, vec3 n, vec3 g)
{
    mat3 axes = mat3(vec3(p[9], p[10], p[11]), vec3(p[12], p[13], p[14]), -axis(p));
    vec3 c = (place(p) - x) * axes, m = n * axes, flat_m = g * axes;
    if (c.z < NEAREST)
        return vec3(0.0);
    vec2 half_size = vec2(p[15], p[16]);
    float up = dot(c, m), reach = dot(half_size, abs(m.xy));
    float high = dot(c, flat_m), wide = dot(half_size, abs(flat_m.xy));
    if (up <= -reach || high <= -wide)
        return vec3(0.0);
    if (high < wide && !shares_plane(n, g))
        return UNKNOWN;
    float e = 0.0;
    if (up >= reach && dot(c, c) > 4.0 * VERY_FAR * VERY_FAR * dot(half_size, half_size)) {
        // Gauss's four points.
        for (int k = 0; k < 4; k++) {
            vec2 sign = vec2(2 * (k & 1) - 1, (k & 2) - 1);
            vec3 d = vec3(c.xy + 0.57735026919 * sign * half_size, c.z);
            e += dot(d, m) / (dot(d, d) * dot(d, d));
        }
        e *= half_size.x * half_size.y * c.z;
    } else {
        // Its sides, of which the horizon cuts off what is below and lays one side in itself.
        vec2 sign[4] = vec2[4](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1));
        vec3 comes = c, goes = c;
        for (int k = 0; k < 4; k++) {
            vec3 a = vec3(c.xy + sign[k] * half_size, c.z);
            vec3 b = vec3(c.xy + sign[(k + 1) % 4] * half_size, c.z);
            float ha = dot(a, m), hb = dot(b, m);
            if (ha <= 0.0 && hb <= 0.0)
                continue;
            vec3 between = a + (ha != hb ? ha / (ha - hb) : 0.0) * (b - a);
            if (ha <= 0.0)
                a = comes = between;
            else if (hb <= 0.0)
                b = goes = between;
            e += side(a, b, m);
        }
        e = max(0.0, up < reach ? e + side(goes, comes, m) : e);
    }
    return intensity(p) * e;
}

vec4 emitted_area(float p[LIGHT_ROW], vec3 o, vec3 d)
{
    vec3 along = vec3(p[9], p[10], p[11]), up = vec3(p[12], p[13], p[14]), c = o - place(p);
    float facing = -dot(d, axis(p)), t = dot(c, axis(p)) / facing;
    vec3 hit = c + t * d;
    bool met = facing > 0.0 && t > 0.0 && abs(dot(hit, along)) <= p[15] && abs(dot(hit, up)) <= p[16];
    return met ? vec4(intensity(p), t) : MISSED;
}
