// The light contract, as in engine/light/base.py.
//
// A light is one file, light/NAME.glsl beside engine/light/NAME.py, with a function
//     Lit illuminate_NAME(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
// that gives what the Python `illuminate` gives; `p` is the light's row. One with extent has
//     vec4 emitted_NAME(float p[LIGHT_ROW], vec3 o, vec3 d)
// as well: the radiance that a ray sees of the light itself, and in w the distance, < 0: missed; and
//     vec3 irradiance_NAME(float p[LIGHT_ROW], vec3 x, vec3 n, vec3 g)
//     Lit glance_NAME(float p[LIGHT_ROW], vec3 x, float size, vec2 u)
// as the Python ones: UNKNOWN where there is no formula, illuminate_NAME where nothing is quicker.

const int LIGHT_ROW = 32;

// One sample of a light: unit direction towards it, distance to it (1e30 at infinity), and the
// incident radiance divided by the density of the sample over solid angle.
struct Lit {
    vec3 w;
    float distance;
    vec3 rgb;
};

const vec4 MISSED = vec4(0.0, 0.0, 0.0, -1.0);
const Lit UNLIT = Lit(vec3(0.0, 0.0, 1.0), 0.0, vec3(0.0));
const vec3 UNKNOWN = vec3(-1.0);

// Whether two unit normals are the same, within a tenth of a degree.
bool shares_plane(vec3 n, vec3 g)
{
    return dot(n, g) > 1.0 - 2e-6;
}

vec3 place(float p[LIGHT_ROW])
{
    return vec3(p[0], p[1], p[2]);
}

vec3 axis(float p[LIGHT_ROW])
{
    return vec3(p[3], p[4], p[5]);
}

vec3 intensity(float p[LIGHT_ROW])
{
    return vec3(p[6], p[7], p[8]);
}
