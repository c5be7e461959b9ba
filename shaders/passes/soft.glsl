// Soft shadows on matt surfaces; twin of engine/backend/cpu/soft.py.

#include "passes/shade.glsl"

bool is_matt(int i)
{
    return points[i].model >= 0
        && max(points[i].row[3], max(points[i].row[4], points[i].row[5])) <= 0.0;
}

// What point i reflects of a light that nothing hides, where it has no formula by `count` samples.
vec3 unshadowed(int i, int first, int count)
{
    vec3 x = points[i].position, n = points[i].normal, g = points[i].geometric;
    if (dot(n, points[i].view) <= 0.0)
        return vec3(0.0);
    vec3 e = irradiance(light, x, n, g);
    if (e.x < 0.0) {
        e = vec3(0.0);
        for (int k = first; k < first + count; k++) {
            Lit l = glance(light, x, points[i].size, samples[k]);
            if (dot(g, l.w) > 0.0)
                e += max(0.0, dot(n, l.w)) / float(count) * l.rgb;
        }
    }
    return diffuse_colour(points[i].row) / PI * e;
}

// Means of what arrives at point i of its group of samples, and of what would without shadows.
// The samples are groups.x and those that follow, in groups.y groups of groups.z.
vec2 look(int i, ivec3 groups, out int visible)
{
    visible = 0;
    vec2 seen = vec2(0.0);
    if (points[i].model < 0)
        return seen;
    vec3 x = points[i].position, n = points[i].normal, g = points[i].geometric;
    vec3 start = x + u_epsilon * g;
    for (int turn = 0; turn < groups.y && seen.y == 0.0; turn++) {
        // All that came before are under the horizon. Is the light? Else others are over it.
        if (turn == 1 && (!is_matt(i) || irradiance(light, x, n, g) == vec3(0.0))) {
            visible = HIDDEN;
            return seen;
        }
        int first = groups.x + (points[i].phase + turn) % groups.y * groups.z;
        for (int k = first; k < first + groups.z; k++) {
            Lit l = glance(light, x, points[i].size, samples[k]);
            float value = dot(n, l.w) * (l.rgb.x + l.rgb.y + l.rgb.z) / float(groups.z);
            if (value <= 0.0 || dot(g, l.w) <= 0.0)
                continue;
            seen.y += value;
            if (hidden(start, x, l))
                visible |= HIDDEN;
            else {
                visible |= VISIBLE;
                seen.x += value;
            }
        }
    }
    if (visible == 0)
        visible = HIDDEN | VISIBLE;
    return seen;
}
