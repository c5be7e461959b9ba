// Radiance that comes along a ray to the eye: the view maps h_k times the light-dependent vectors
// (eq. 5); twin of engine/methods/glossy_prt/views.py, and of `_shade` in shade.py.

#include "common/frames.glsl"
#include "common/hemisphere_maps.glsl"
#include "common/seen.glsl"
#include "light/environment.glsl"

const int EVEN = 0, BOTH_VARY = 2;

struct Material {
    vec3 emission;
    int first; // row of the first vertex's first vector
    vec3 diffuse;
    int vertex; // the first vertex
    vec3 specular;
    int terms; // K
    ivec3 diffuse_map; // first texel, width, height of what it is multiplied by; -1 for none
    int size; // texels along a view map
    ivec3 specular_map;
    int texel; // the view map's first one
    int textured; // see `Terms`
};
struct Vertex {
    vec3 normal;
    float unused;
    vec3 tangent;
    float unused_too;
};
layout(std430) readonly buffer b_materials { Material materials[]; };
layout(std430) readonly buffer b_vertices { Vertex vertices[]; };
// Vertices of a triangle; in w, whether the frames at its corners are much the same.
layout(std430) readonly buffer b_of_triangle { ivec4 of_triangle[]; };
layout(std430) readonly buffer b_uvs { vec2 uvs[]; }; // three a triangle, none far below 0
layout(std430) readonly buffer b_texels { float texels[]; }; // of all textures, in threes
layout(std430) readonly buffer b_h { float h[]; };     // view maps, in threes: texel by texel, term by term
layout(std430) readonly buffer b_lit { float lit[]; }; // light-dependent vectors, (rows, 3)

uniform float u_lowest; // cosine of a view below which maps are not looked up

// Bilinear, repeating.
vec3 texel(ivec3 map, vec2 uv)
{
    if (map.x < 0)
        return vec3(1.0);
    ivec2 size = map.yz;
    vec2 x = uv * vec2(size) - 0.5, low = floor(x), f = x - low;
    vec3 sum = vec3(0.0);
    for (int j = 0; j < 4; j++) {
        ivec2 k = ivec2(j & 1, j >> 1), at = (ivec2(low) + k + size) % size;
        vec2 w = mix(1.0 - f, f, vec2(k));
        int i = 3 * (map.x + at.y * size.x + at.x);
        sum += w.x * w.y * vec3(texels[i], texels[i + 1], texels[i + 2]);
    }
    return sum;
}

// Where w is looked up in view maps, in the frame of a normal and a tangent.
Taps taps_of(Material m, vec3 w, vec3 n, vec3 s)
{
    vec3 l = to_local(w, s, cross(n, s), n);
    return disk_taps(normalize(vec3(l.xy, max(l.z, u_lowest))), m.size);
}

// h_k there.
vec3 view_map(Material m, Taps taps, int k)
{
    vec3 sum = vec3(0.0);
    for (int j = 0; j < 4; j++) {
        int i = 3 * ((m.texel + taps.texel[j]) * m.terms + k);
        sum += taps.weight[j] * vec3(h[i], h[i + 1], h[i + 2]);
    }
    return sum;
}

vec3 lit_at(int row)
{
    return vec3(lit[3 * row], lit[3 * row + 1], lit[3 * row + 2]);
}

// What is reflected towards w where it leaves a triangle.
vec3 reflected(Seen s, vec3 w)
{
    Triangle t = triangles[s.triangle];
    if (dot(cross(t.b - t.a, t.c - t.a), w) <= 0.0)
        return vec3(0.0);
    Material m = materials[t.material];
    ivec4 corner = of_triangle[s.triangle];
    ivec3 row = m.first + (corner.xyz - m.vertex) * m.terms;
    vec3 b = vec3(1.0 - s.b1 - s.b2, s.b1, s.b2), light = vec3(0.0);
    vec3 base = vec3(1.0), gloss = vec3(1.0); // what scales term 0, and the others
    if (m.textured != EVEN) {
        int i = 3 * s.triangle;
        vec2 uv = b.x * uvs[i] + b.y * uvs[i + 1] + b.z * uvs[i + 2];
        base = m.diffuse * texel(m.diffuse_map, uv);
        if (m.textured == BOTH_VARY)
            gloss = m.specular * texel(m.specular_map, uv);
    }
    // A constant needs no frame; frames that turn by too much to go between are taken one by one.
    if (m.size == 1 || corner.w != 0) {
        Taps taps = Taps(ivec4(0), vec4(1.0, 0.0, 0.0, 0.0));
        if (m.size > 1) {
            vec3 n = vec3(0.0), along = vec3(0.0);
            for (int c = 0; c < 3; c++) {
                n += b[c] * vertices[corner[c]].normal;
                along += b[c] * vertices[corner[c]].tangent;
            }
            n = unit(n);
            taps = taps_of(m, w, n, unit(along - dot(along, n) * n));
        }
        for (int k = 0; k < m.terms; k++) {
            vec3 mixed = b.x * lit_at(row.x + k) + b.y * lit_at(row.y + k) + b.z * lit_at(row.z + k);
            light += view_map(m, taps, k) * (k == 0 ? base : gloss) * mixed;
        }
    } else
        for (int c = 0; c < 3; c++) {
            Taps taps = taps_of(m, w, vertices[corner[c]].normal, vertices[corner[c]].tangent);
            for (int k = 0; k < m.terms; k++)
                light += b[c] * view_map(m, taps, k) * (k == 0 ? base : gloss) * lit_at(row[c] + k);
        }
    return max(light, 0.0);
}

// All that comes from where a ray along `away` leads.
vec3 radiance(Seen s, vec3 away)
{
    if (s.triangle < 0)
        return seen_radiance(away);
    return reflected(s, -away) + materials[triangles[s.triangle].material].emission;
}
