// The light of one light at one place, with shadows; twin of engine/backend/cpu/shading.py.

#include "brdf/table.glsl"
#include "common/bvh.glsl"
#include "common/frames.glsl"
#include "common/points.glsl"
#include "light/base.glsl"
#include "light/chosen.glsl"

layout(std430) readonly buffer b_light { float light[LIGHT_ROW]; };
layout(std430) readonly buffer b_samples { vec2 samples[]; }; // (groups, k) places on it

uniform int u_groups; // of which a point's phase picks one
uniform int u_per_point; // k
uniform float u_epsilon; // metres that rays start off the surface

// Both may hold of a light with extent, neither where there is no surface.
const int HIDDEN = 1, VISIBLE = 2;

// Whether anything lies between a place x, left at `start`, and a sample of the light.
bool hidden(vec3 start, vec3 x, Lit l)
{
    // Almost to the light; a light at infinity is as far as a ray goes.
    bool far = l.distance > 1e20;
    vec3 way = far ? l.w : x + max(l.distance - u_epsilon, 0.0) * l.w - start;
    return occluded(start, way, far ? 1e30 : 1.0);
}

// Reflected radiance of the light at x on the surface of point i, from `count` of its samples.
// Without shadows nothing hides the light.
vec3 light_at(int i, vec3 x, int first, int count, bool shadows, out int visible)
{
    visible = 0;
    int model = points[i].model;
    if (model < 0)
        return vec3(0.0);
    vec3 n = points[i].normal, g = points[i].geometric, s, t;
    tangents(n, s, t);
    vec3 wo = to_local(points[i].view, s, t, n), sum = vec3(0.0), start = x + u_epsilon * g;
    for (int k = first; k < first + count; k++) {
        Lit l = illuminate(light, x, points[i].size, samples[k]);
        float cosine = dot(n, l.w);
        if (cosine <= 0.0 || dot(g, l.w) <= 0.0 || l.rgb.x + l.rgb.y + l.rgb.z <= 0.0)
            continue;
        vec3 f = evaluate(model, points[i].row, to_local(l.w, s, t, n), wo);
        if (f.x + f.y + f.z <= 0.0)
            continue;
        if (shadows && hidden(start, x, l))
            visible |= HIDDEN;
        else {
            visible |= VISIBLE;
            sum += f * l.rgb * cosine;
        }
    }
    if (visible == 0)
        visible = HIDDEN;
    return sum / float(count);
}

// The same from the samples of the point's group, with shadows.
vec3 light_at(int i, vec3 x, out int visible)
{
    int first = points[i].phase % u_groups * u_per_point;
    return light_at(i, x, first, u_per_point, true, visible);
}
