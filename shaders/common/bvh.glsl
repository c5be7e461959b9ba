// Rays through the tree of engine/backend/gl/bvh.py.

// Four rows per node: the lower and upper corners of both children's boxes, and in w of the first
// two what the children are: a node's index, or -1 - (8 * first + count) for so many triangles.
layout(std430) readonly buffer b_nodes { vec4 nodes[]; };
// Three corners per triangle; in w of the first, which of the scene's it is.
layout(std430) readonly buffer b_corners { vec4 corners[]; };

const int STACK = 64; // the builder keeps the tree less deep than this

// How many times d it is from the origin to a triangle; below 0 where the ray along d misses it.
//
// The ray passes an edge on the side that the sign of a triple product tells (Plücker coordinates).
// Two triangles find the same number for the edge they share, up to its sign, so no ray slips
// through between them: that needs every product rounded by itself, hence `precise`.
float crossing(vec3 a, vec3 b, vec3 c, vec3 d)
{
    precise vec3 ab = cross(a - b, a + b), bc = cross(b - c, b + c), ca = cross(c - a, c + a);
    precise float u = ab.x * d.x + ab.y * d.y + ab.z * d.z;
    precise float v = bc.x * d.x + bc.y * d.y + bc.z * d.z;
    precise float w = ca.x * d.x + ca.y * d.y + ca.z * d.z;
    // The products themselves are rounded too: a ray aimed at an edge belongs to both sides.
    float tolerance = 5e-7 * abs(u + v + w);
    if (min(u, min(v, w)) < -tolerance && max(u, max(v, w)) > tolerance)
        return -1.0;
    vec3 n = cross(b - a, c - a);
    float slope = dot(d, n);
    return slope == 0.0 ? -1.0 : dot(a, n) / slope;
}

// The distance at which a ray enters a box, in units of its direction; beyond `limit`: it does not.
float enters(vec3 low, vec3 high, vec3 o, vec3 inverse, float limit)
{
    vec3 a = (low - o) * inverse, b = (high - o) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float start = max(max(near.x, near.y), max(near.z, 0.0));
    // Rounding must not shut a ray out (Ize 2013, Robust BVH Ray Traversal).
    float end = min(min(far.x, far.y), min(far.z, limit)) * 1.000001;
    return start <= end ? start : 3.4e38;
}

// The place in the tree of what a ray meets between o and o + limit * d: the first triangle, or just
// any; -1 for none.
int traced(vec3 o, vec3 d, float limit, const bool any_will_do)
{
    int found = -1;
    vec3 safe = mix(d, vec3(1e-30), equal(d, vec3(0.0)));
    vec3 inverse = 1.0 / safe;
    int stack[STACK];
    int top = 0, node = 0;
    while (true) {
        if (node < 0) {
            int leaf = -1 - node;
            for (int k = leaf >> 3; k < (leaf >> 3) + (leaf & 7); k++) {
                float t = crossing(corners[3 * k].xyz - o, corners[3 * k + 1].xyz - o,
                                   corners[3 * k + 2].xyz - o, d);
                if (t < 0.0 || t > limit)
                    continue;
                if (any_will_do)
                    return k;
                found = k;
                limit = t;
            }
        } else {
            vec4 low0 = nodes[4 * node], low1 = nodes[4 * node + 1];
            float t0 = enters(low0.xyz, nodes[4 * node + 2].xyz, o, inverse, limit);
            float t1 = enters(low1.xyz, nodes[4 * node + 3].xyz, o, inverse, limit);
            int near = floatBitsToInt(low0.w), far = floatBitsToInt(low1.w);
            if (t1 < t0) {
                int other = near;
                near = far;
                far = other;
            }
            if (max(t0, t1) < 3e38)
                stack[top++] = far;
            if (min(t0, t1) < 3e38) {
                node = near;
                continue;
            }
        }
        if (top == 0)
            return found;
        node = stack[--top];
    }
}

// Whether anything lies between o and o + limit * d.
bool occluded(vec3 o, vec3 d, float limit)
{
    return traced(o, d, limit, true) >= 0;
}

// The scene's triangle that a ray from o along d meets first, -1 for none.
int nearest(vec3 o, vec3 d)
{
    int k = traced(o, d, 1e30, false);
    return k < 0 ? -1 : floatBitsToInt(corners[3 * k].w);
}
