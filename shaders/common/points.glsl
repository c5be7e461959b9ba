// Surface points, as engine/backend/gl/points.py packs them.

#include "brdf/base.glsl"

struct Point {
    vec3 position;
    float size; // width of what it stands for
    vec3 normal;
    int model; // of the BRDF, -1 where there is no surface
    vec3 geometric;
    int phase; // which places of a light with extent shine here
    vec3 view;
    float unused;
    float row[BRDF_ROW];
};
layout(std430) readonly buffer b_points { Point points[]; };
