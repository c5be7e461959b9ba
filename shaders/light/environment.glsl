// What is seen of an environment, its map and its area light; twin of engine/light/environment_samples.py.

#include "common/angles.glsl"

layout(std430) readonly buffer b_map { float map_texels[]; }; // (height, width, 3)

uniform ivec2 u_map; // width and height, 0 where there is none
uniform float u_map_shift; // part of a whole turn
uniform float u_map_factor;
uniform vec4 u_disk; // towards the middle of the area light; its radius, radians
uniform vec3 u_disk_radiance;
uniform float u_rim; // radians over which the light ends

// Column and row, 0 to 1, where the unit direction d lies on a map that is not turned.
vec2 place_on_map(vec3 d)
{
    vec2 level = vec2(abs(d.x), -d.z);
    float around = level == vec2(0.0) ? 0.0 : angle(level.x, level.y);
    return vec2(0.5 + (d.x < 0.0 ? -around : around) / (2.0 * PI), angle(length(level), d.y) / PI);
}

vec3 seen_radiance(vec3 d)
{
    if (u_map.x == 0)
        return vec3(0.0);
    float away = angle(length(cross(u_disk.xyz, d)), dot(u_disk.xyz, d));
    vec3 light = clamp(0.5 + (u_disk.w - away) / u_rim, 0.0, 1.0) * u_disk_radiance;
    vec2 place = place_on_map(d);
    ivec2 pixel = min(ivec2(vec2(fract(place.x + u_map_shift), place.y) * vec2(u_map)), u_map - 1);
    int i = 3 * (pixel.y * u_map.x + pixel.x);
    return light + u_map_factor * vec3(map_texels[i], map_texels[i + 1], map_texels[i + 2]);
}
