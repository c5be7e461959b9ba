// Images in lights; twin of engine/light/pyramid.py.

// The images of a light table, three numbers per texel.
layout(std430) readonly buffer b_texels { float texels[]; };

const int STEP = 64;

vec3 texel(int k)
{
    return vec3(texels[3 * k], texels[3 * k + 1], texels[3 * k + 2]);
}

vec3 bilinear(int start, ivec2 size, vec2 uv)
{
    vec2 at = uv * vec2(size) - 0.5, low = floor(at), part = at - low;
    ivec2 i = clamp(ivec2(low), ivec2(0), size - 1), j = clamp(ivec2(low) + 1, ivec2(0), size - 1);
    vec3 top = mix(texel(start + i.y * size.x + i.x), texel(start + i.y * size.x + j.x), part.x);
    vec3 bottom = mix(texel(start + j.y * size.x + i.x), texel(start + j.y * size.x + j.x), part.x);
    return mix(top, bottom, part.y);
}

// Colour at uv in [0, 1]², v from the top, between pixels; trilinear from level `lod`. `image` is
// the place of the first texel in steps of STEP, and the size of the first level.
vec3 look_up(vec3 image, vec2 uv, float lod)
{
    int start = int(image.x) * STEP;
    ivec2 size = ivec2(image.yz);
    lod = max(0.0, lod);
    while (lod >= 1.0 && (size.x > 1 || size.y > 1)) {
        start += size.x * size.y;
        size = max(ivec2(1), size / 2);
        lod -= 1.0;
    }
    vec3 fine = bilinear(start, size, uv);
    if (lod == 0.0 || (size.x == 1 && size.y == 1))
        return fine;
    start += size.x * size.y;
    return mix(fine, bilinear(start, max(ivec2(1), size / 2), uv), lod);
}
