// Twin of engine/numerics/tangent_poles.py: the hemisphere as a square, poles along the tangent.

#include "common/angles.glsl"

// The angle of (x, y) for y >= 0, in halves of a turn.
float half_turns(float y, float x)
{
    float r = length(vec2(x, y));
    if (r <= 0.0)
        return 0.5;
    float part = y / r * angle_over_sine(abs(x) / r) / PI;
    return x >= 0.0 ? part : 1.0 - part;
}

// (θ, φ) / π of a direction with z >= 0.
vec2 tangent_coordinates(vec3 w)
{
    return vec2(half_turns(w.z, w.x), half_turns(length(w.xz), w.y));
}
