// Twin of engine/numerics/angles.py: Abramowitz and Stegun 1964, 4.4.46.

#include "common/sampling.glsl"

// acos c / √(1 - c) for c from 0 to 1.
float acos_over_root(float c)
{
    float a = 0.0066700901 - 0.0012624911 * c;
    a = 0.0308918810 + c * (a * c - 0.0170881256);
    a = 0.0889789874 + c * (a * c - 0.0501743046);
    return 1.5707963050 + c * (a * c - 0.2145988016);
}

// γ / sin γ for cos γ = c.
float angle_over_sine(float c)
{
    if (c >= 0.0)
        return acos_over_root(c) / sqrt(1.0 + c);
    return PI / sqrt(max(1e-30, (1.0 - c) * (1.0 + c))) - acos_over_root(-c) / sqrt(1.0 - c);
}

// The angle of (x, y) for y >= 0; the atan of a driver may be 1e-4 off.
float angle(float y, float x)
{
    float r = length(vec2(x, y));
    return x >= 0.0 ? y / r * angle_over_sine(x / r) : PI - y / r * angle_over_sine(-x / r);
}
