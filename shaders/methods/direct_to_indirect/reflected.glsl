// What view samples do with the light that arrives: k_d and k_g of eq. 5 and 6, times π.

layout(std430) readonly buffer b_arriving { float arriving[]; };
layout(std430) readonly buffer b_mirrored { float mirrored[]; };
layout(std430) readonly buffer b_matt { float matt[]; };
layout(std430) readonly buffer b_gloss { float gloss[]; };

// One number of sample `taker`, from the light of the pixel `giver`, both 3 * index + channel.
float reflected(int giver, int taker)
{
    // Culled wavelets can leave a little less than no light.
    return max(matt[taker] * arriving[giver] + gloss[taker] * mirrored[giver], 0.0) * 0.3183098861837907;
}
