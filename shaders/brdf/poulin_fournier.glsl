// Twin of engine/brdf/poulin_fournier.py: Poulin and Fournier 1990.

#include "brdf/blinn_phong.glsl"
#include "common/angles.glsl"

// Half of the Gauss-Legendre points; the others lie opposite.
const float PLACES[6] = float[6](0.12523340851146891, 0.36783149899818018, 0.58731795428661748,
                                 0.76990267419430469, 0.90411725637047491, 0.98156063424671924);
const float WEIGHTS[6] = float[6](0.24914704581340269, 0.23349253653835464, 0.20316742672306565,
                                  0.16007832854334611, 0.10693932599531888, 0.04717533638651202);
const float FAINTEST = 9.0;

// (θ from, θ to, floor in the shade): what the direction w = (y, z) of the cross-section reaches.
vec3 reached(float edge, float floor_width, vec2 w)
{
    float elevation = angle(w.y, abs(w.x));
    vec3 r = vec3(-edge, edge, 0.0);
    if (edge < 0.0)
        r = vec3(max(edge, -edge - 2.0 * elevation), -edge, 0.0);
    else if (elevation < edge) {
        float sine = sin(elevation), lean = sin(0.5 * (edge - elevation));
        float v = min(1.0, 0.5 * (floor_width + 2.0 * sin(edge)) * sine);
        float high = 2.0 * angle(sqrt(v), sqrt(1.0 - v)) - elevation;
        r = vec3(-elevation, min(edge, high),
                 min(floor_width, 2.0 * lean * lean / max(1e-30, sine)));
    }
    return w.x >= 0.0 ? r : vec3(-r.y, -r.x, r.z);
}

// x - sin x, which has no digits of small x.
float less_sine(float x)
{
    float q = x * x;
    return x < 0.5 ? x * q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0)))
                   : x - sin(x);
}

// ∫ (n·a)(n·b) dθ.
float matt_arc(float low, float high, vec2 a, vec2 b)
{
    float width = high - low, middle = 0.5 * (low + high);
    vec2 n = vec2(sin(middle), cos(middle));
    return max(0.0, sin(width) * dot(n, a) * dot(n, b) + 0.5 * less_sine(width) * dot(a, b));
}

// (n·h)^e (n·a)(n·b) in the frame of h.
float facet(vec2 n, float e, vec2 a, vec2 b)
{
    float s = n.x * n.x;
    float mirrored = s < 0.3 ? exp2(0.72134752 * e * log1p_near_zero(-s)) : power(max(0.0, n.y), e);
    return mirrored * max(0.0, dot(n, a)) * max(0.0, dot(n, b));
}

// ∫ (n·h)^e (n·a)(n·b) dθ.
float lobe_arc(float low, float high, float e, vec3 h, vec2 a, vec2 b)
{
    float size = length(h.yz);
    if (size <= 0.0)
        return 0.0;
    vec2 up = h.yz / size;
    mat2 turn = mat2(up.y, up.x, -up.x, up.y);
    float middle = angle(up.x, up.y);
    float least = exp(-FAINTEST / max(0.01, e));
    float reach = angle(sqrt(1.0 - least * least), least);
    float first = max(-reach, low - middle), last = min(reach, high - middle);
    if (first >= last)
        return 0.0;
    float x = 0.5 * (first + last), r = 0.5 * (last - first), total = 0.0;
    a = turn * a;
    b = turn * b;
    for (int k = 0; k < 6; k++)
        for (int side = -1; side <= 1; side += 2) {
            float t = x + float(side) * r * PLACES[k];
            total += WEIGHTS[k] * facet(vec2(sin(t), cos(t)), e, a, b);
        }
    return total * r * lobe(h, vec3(0.0, up), e);
}

vec3 evaluate_poulin_fournier(float p[BRDF_ROW], vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float e = p[6], edge = p[7], floor_width = p[8];
    vec3 a = to_grain(p, wi), b = to_grain(p, wo), h = normalize(a + b);
    vec3 ra = reached(edge, floor_width, a.yz), rb = reached(edge, floor_width, b.yz);
    float low = max(ra.x, rb.x), high = min(ra.y, rb.y);
    float shade = a.y * b.y >= 0.0 ? max(ra.z, rb.z) : ra.z + rb.z;
    float matt = a.z * b.z * max(0.0, floor_width - shade);
    float gloss = matt * lobe(h, vec3(0.0, 0.0, 1.0), e);
    if (low < high) {
        matt += matt_arc(low, high, a.yz, b.yz);
        gloss += lobe_arc(low, high, e, h, a.yz, b.yz);
    }
    float unit = 1.0 / max(1e-30, a.z * b.z * (floor_width + 2.0 * sin(abs(edge))));
    return (diffuse_colour(p) * (matt / PI) + specular_colour(p) * (gloss * normalisation(e))) * unit;
}
