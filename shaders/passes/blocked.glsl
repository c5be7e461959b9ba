// What stands around some eyes: a row of six tiles for each, one for each face of its cube map.
// One of both stages is compiled at a time.

#ifdef VERTEX
#include "common/cube_map.glsl"

uniform int u_eyes;
uniform float u_near; // metres; what is nearer is cut off

in vec3 in_position;
in vec3 in_eye; // of an instance: six each

out float gl_ClipDistance[4]; // a face is a part of the target, so it has edges of its own

void main()
{
    ivec2 tile = ivec2(gl_InstanceID % 6, gl_InstanceID / 6), tiles = ivec2(6, u_eyes);
    vec3 p = to_face(tile.x, in_position - in_eye);
    gl_ClipDistance[0] = p.z - p.x;
    gl_ClipDistance[1] = p.z + p.x;
    gl_ClipDistance[2] = p.z - p.y;
    gl_ClipDistance[3] = p.z + p.y;
    gl_Position = vec4((p.xy + vec2(2 * tile + 1 - tiles) * p.z) / vec2(tiles), -u_near, p.z);
}
#else
out float blocked;

void main()
{
    blocked = 1.0;
}
#endif
