// Which triangle each pixel shows, by the rasteriser; twin of engine/backend/cpu/raster.py.
//
// Row 0 of the target is the top row of the picture. Depth is linear in distance, so that 24 bits
// tell apart what float32 coordinates do. One of both stages is compiled at a time.

#ifdef VERTEX
uniform vec3 u_eye;
uniform mat3 u_to_pixels; // a direction to (x d, y d, d); centres of pixels are whole numbers
uniform vec2 u_size;      // of the picture, pixels
uniform float u_near;     // what is nearer is cut off

in vec3 in_position;

void main()
{
    vec3 p = u_to_pixels * (in_position - u_eye);
    gl_Position = vec4((2.0 * p.xy + p.z) / u_size - p.z, -u_near, p.z);
}
#else
uniform float u_far; // what is farther is not there

out int id; // 0 stands for no triangle

void main()
{
    id = gl_PrimitiveID + 1;
    gl_FragDepth = 1.0 / (gl_FragCoord.w * u_far);
}
#endif
