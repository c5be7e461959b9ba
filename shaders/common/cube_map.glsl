// The faces of a cube map, +X -X +Y -Y +Z -Z; twin of engine/numerics/cube_map.py.

const vec3 AHEAD[6] = vec3[6](vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0),
                              vec3(0, 0, 1), vec3(0, 0, -1));
const vec3 RIGHT[6] = vec3[6](vec3(0, 0, -1), vec3(0, 0, 1), vec3(1, 0, 0), vec3(1, 0, 0),
                              vec3(1, 0, 0), vec3(-1, 0, 0));
const vec3 DOWN[6] = vec3[6](vec3(0, -1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1),
                             vec3(0, -1, 0), vec3(0, -1, 0));

// The direction, of any length, of a place on a face, from -1 to 1 to the right and down.
vec3 on_face(int face, vec2 x)
{
    return x.x * RIGHT[face] + x.y * DOWN[face] + AHEAD[face];
}

// How far v goes to the right, down and ahead.
vec3 to_face(int face, vec3 v)
{
    return vec3(dot(v, RIGHT[face]), dot(v, DOWN[face]), dot(v, AHEAD[face]));
}

// (x, y) of a number in quad-tree order, below 2^16.
ivec2 from_morton(int number)
{
    ivec2 x = ivec2(0);
    for (int bit = 0; bit < 8; bit++)
        x |= (ivec2(number, number >> 1) >> 2 * bit & 1) << bit;
    return x;
}
