// How many parts of each texel of the eyes' cube maps are open and above the horizon; twin of
// `open_parts` in engine/methods/glossy_prt/visibility.py, which asks rays.

#include "common/cube_map.glsl"
#include "common/each.glsl"

layout(std430) readonly buffer b_normals { float normals[]; }; // (eyes, 3)
layout(std430) writeonly buffer b_open { uint open[]; }; // (eyes, 6 u_light²) bytes, four to a word

uniform sampler2D u_blocked; // as passes/blocked.glsl draws it
uniform int u_count; // words
uniform int u_light; // texels along a face
uniform int u_parts; // of a texel, along it

// How many parts of a texel of the eye's cube map are open.
uint open_parts(int eye, int texel)
{
    int face = texel / (u_light * u_light), size = u_light * u_parts;
    ivec2 first = u_parts * from_morton(texel % (u_light * u_light));
    vec3 n = vec3(normals[3 * eye], normals[3 * eye + 1], normals[3 * eye + 2]);
    uint found = 0u;
    for (int k = 0; k < u_parts * u_parts; k++) {
        ivec2 x = first + ivec2(k % u_parts, k / u_parts);
        bool above = dot(n, on_face(face, vec2(2 * x + 1) / float(size) - 1.0)) > 0.0;
        if (above && texelFetch(u_blocked, size * ivec2(face, eye) + x, 0).x == 0.0)
            found++;
    }
    return found;
}

void main()
{
    int of_eye = 6 * u_light * u_light;
    for (EACH(i, u_count)) {
        uint word = 0u;
        for (int k = 0; k < 4; k++)
            word |= open_parts(4 * i / of_eye, 4 * i % of_eye + k) << 8 * k;
        open[i] = word;
    }
}
