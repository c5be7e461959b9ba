"""BRDFs encoded by wavelets: Claustres, Barthe, Paulin 2007, *Wavelet Encoding of BRDFs for
Real-Time Rendering*.

    f(wi, wo) = M(wi) Π_k s_k(wi) / W_wo,    s = 1 / (1 + e) or e / (1 + e),    e = (w_B / w_A) e⁻ᵈ

along the way from the root of a binary tree of outgoing directions down to the cell of wo (§4.2):
M is what the hemisphere reflects of light from wi, s the part of a half, d a coefficient, W the
projected solid angle of the cell. Every coefficient is a slice over the plane of wi.

| the paper | here |
|---|---|
| (x, y, z) of θ, φ, §4.1 | `engine.numerics.tangent_poles` |
| l, h, f_r, §4.2 | `analysis`: means and log-ratios, after which no energy is lost |
| vectors of hemispherical coefficients and their threshold, §4.3 | `tiles`, by their weight |
| μ, ε, 8 bits, §5.1 | `errors.floors`, `tiles` |
| 3-D texture, compression map, slice 0, §5.2 | `layout`, `packing`: tiles, map, tile 0 |
| 4 N + 1 look-ups, §5.3 | `synthesis`, `shaders/brdf/wavelet.glsl` |
| levels of detail, §5.4.1 | `synthesis`: a level stops above the leaves |
| bilinear, §5.4.2 | `synthesis`: coefficients over wi, values over wo |

Past the paper: isotropic and mirrored BRDFs keep to a part of the directions (`tabulate`), slices
are cut into tiles, levels keep their energy, and the tree is what rays are sampled from
(`sampling`).
"""
