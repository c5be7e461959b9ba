// The triangles of a scene, as engine/backend/gl/seen.py packs them.

struct Triangle {
    vec3 a;
    int material;
    vec3 b;
    int object;
    vec3 c;
    int unused;
};
layout(std430) readonly buffer b_triangles { Triangle triangles[]; };
