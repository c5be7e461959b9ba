// List the pixels beside which another object or material is seen, or something farther off; twin of
// `_find_edges` in engine/methods/glossy_prt/view.py.
//
// Before rays are cast there are others in doubt. The rasteriser moves corners by up to a 512th of a
// pixel: it may show a triangle that the ray through the pixel's centre just misses, or, which is an
// edge then, miss one that the ray meets.

#include "common/each.glsl"
#include "common/seen.glsl"

layout(std430) readonly buffer b_seen { Seen seen[]; };
layout(std430) buffer b_list { int listed; int pixels[]; };

uniform int u_count;
uniform int u_in_doubt; // whether to list pixels in doubt as well
uniform float u_step;   // from a pixel to the next, of their distance

bool is_edge(Seen a, Seen b)
{
    if (a.triangle == b.triangle)
        return false;
    if (a.triangle < 0 || b.triangle < 0)
        return true;
    return triangles[a.triangle].material != triangles[b.triangle].material
        || triangles[a.triangle].object != triangles[b.triangle].object
        || abs(a.distance - b.distance) > u_step * min(a.distance, b.distance);
}

void main()
{
    for (EACH(i, u_count)) {
        int x = i % u_width;
        Seen s = seen[i];
        // Seen from its edge a triangle has no barycentrics, and no number is not inside either.
        bool found = u_in_doubt != 0 && !(min(min(s.b1, s.b2), 1.0 - s.b1 - s.b2) >= 0.0);
        if (x > 0)
            found = found || is_edge(s, seen[i - 1]);
        if (x + 1 < u_width)
            found = found || is_edge(s, seen[i + 1]);
        if (i >= u_width)
            found = found || is_edge(s, seen[i - u_width]);
        if (i + u_width < u_count)
            found = found || is_edge(s, seen[i + u_width]);
        if (found)
            pixels[atomicAdd(listed, 1)] = i;
    }
}
