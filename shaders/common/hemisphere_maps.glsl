// Square textures over the upper hemisphere; twin of engine/numerics/hemisphere_maps.py.

struct Taps {
    ivec4 texel;
    vec4 weight;
};

// The four texels about the local direction w of a map by the disk, size texels wide.
Taps disk_taps(vec3 w, int size)
{
    vec2 x = 0.5 * (w.xy + 1.0) * float(size) - 0.5, low = floor(x), f = x - low;
    ivec2 a = max(ivec2(low), 0), b = min(ivec2(low) + 1, size - 1);
    return Taps(ivec4(a.y * size + a.x, a.y * size + b.x, b.y * size + a.x, b.y * size + b.x),
                vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y));
}
