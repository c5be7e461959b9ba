// Local frames: z is the normal; twin of engine/numerics/frames.py, which says where they are from.

// v / |v|; the zero vector stays zero.
vec3 unit(vec3 v)
{
    float size = length(v);
    return size == 0.0 ? v : v / size;
}

// (s, t) for a unit normal n: s, t, n is right-handed and orthonormal.
void tangents(vec3 n, out vec3 s, out vec3 t)
{
    float m = n.x * n.x + n.z * n.z;
    float a = n.y > 0.0 ? n.y + 1.0 : m / (1.0 - n.y);
    s = vec3(1.0, 0.0, 0.0);
    if (m >= 1e-20) {
        vec3 v = vec3(a * a + n.z * n.z - n.x * n.x, -2.0 * a * n.x, -2.0 * n.x * n.z);
        // Near n.y = -1 it is so short that its square would be no float32.
        s = normalize(v / max(a, m));
    }
    t = cross(n, s);
}

// World direction w in the frame (s, t, n).
vec3 to_local(vec3 w, vec3 s, vec3 t, vec3 n)
{
    return vec3(dot(w, s), dot(w, t), dot(w, n));
}

// Local direction w of the frame (s, t, n) in the world.
vec3 to_world(vec3 w, vec3 s, vec3 t, vec3 n)
{
    return w.x * s + w.y * t + w.z * n;
}
