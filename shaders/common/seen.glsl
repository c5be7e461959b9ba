// What rays from the eye meet; twin of `Seen` on the CPU (`engine.methods.glossy_prt.view`).

#include "common/triangles.glsl"

struct Seen {
    int triangle; // -1 for none
    float b1, b2; // barycentrics of its second and third corner
    float distance;
};

uniform vec3 u_eye;
uniform mat3 u_from_pixels; // (x, y, 1) to a direction; centres of pixels are whole numbers
uniform int u_width;

const float NOTHING = 3.4e38; // metres to it

// Unit direction from the eye through pixel i, moved by so many pixels.
vec3 ray(int i, vec2 offset)
{
    return normalize(u_from_pixels * vec3(vec2(i % u_width, i / u_width) + offset, 1.0));
}

// Where the ray from the eye along w meets the plane of triangle t, -1 for none.
Seen meet(int t, vec3 w)
{
    if (t < 0)
        return Seen(-1, 0.0, 0.0, NOTHING);
    vec3 p = triangles[t].a, e1 = triangles[t].b - p, e2 = triangles[t].c - p;
    vec3 n = cross(e1, e2), s = p - u_eye;
    float far = dot(n, s) / dot(n, w);
    vec3 q = cross(far * w - s, n) / dot(n, n);
    // q · e is what is left of the cross products in the plane.
    return Seen(t, -dot(q, e2), dot(q, e1), far);
}
