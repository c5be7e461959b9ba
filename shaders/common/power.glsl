// Powers with all their digits: the pow of a driver may be 1e-4 off, and sharp lobes more.

// log(1 + x) for x from -0.3 to 0.42, by 2 atanh(x / (2 + x)).
float log1p_near_zero(float x)
{
    float s = x / (2.0 + x);
    float q = s * s;
    return 2.0 * s * (1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q / 11.0)))));
}

// x^y for x >= 0: 0^y is 0 for y > 0, 1 for y = 0.
float power(float x, float y)
{
    if (y == 0.0)
        return 1.0;
    if (x <= 0.0)
        return y > 0.0 ? 0.0 : 3e38;
    int e;
    float m = frexp(x, e);
    if (m < 0.70710678) {
        m *= 2.0;
        e -= 1;
    }
    // 2^(y e) times m^y, whole powers of two apart so that no digit is lost.
    float binary = y * float(e);
    float whole = floor(binary + 0.5);
    float rest = (binary - whole) * 0.69314718 + y * log1p_near_zero(m - 1.0);
    return exp2(clamp(whole + rest * 1.44269504, -149.0, 127.9));
}

// (a · b)^n for unit vectors, from the distance between them, which has more digits.
float lobe(vec3 a, vec3 b, float n)
{
    vec3 d = a - b;
    float versine = 0.5 * dot(d, d);
    if (versine < 0.3)
        return exp2(max(-149.0, n * log1p_near_zero(-versine) * 1.44269504));
    return power(max(0.0, 1.0 - versine), n);
}
