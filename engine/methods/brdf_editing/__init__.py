"""`brdf_editing`: Ben-Artzi, Egan, Ramamoorthi, Durand 2008, materials changed under the hand.

*A Precomputed Polynomial Representation for Interactive BRDF Editing with Global Illumination.* The
geometry, the camera and the light stand still; materials change. A picture is a polynomial in the
coefficients c of the BRDFs (eq. 14), which the paper tabulates: a tensor with an element for every
combination of what light has met on its way, a thousand million numbers for a Cornell box, and a
thousand times as many for thirty objects.

Here the tensor is never formed. Its first factor, from the eye, is geometry: what every ray of a
pixel meets (`links`), and which lights it sees (`light_seen`). Its others are matt, so they are the
light on a gather cloud, a polynomial in the one albedo that is in hand (`polynomial`). When a
material is taken in hand both are folded (`fold`) into what the paper has too, eq. 28:

    B(x) = Σ_n dⁿ Σ_j c_j F_jn(x)

with d the equivalent albedo (`engine.brdf.equivalent_albedo`) and c_j what the curves of the
material are made of (`engine.brdf.layers`, `curve_basis`). A frame is these sums.

| the paper | here |
|---|---|
| ρ^m, c_j^m, b_j^m | `layers.LAYERS`, `curve_basis.coefficients`, `weights_at` |
| d_m, e_j | `equivalent_albedo.shares` |
| T^N_jz | `links`, `light_seen` and `CloudLight`, never multiplied out |
| F^i_jn, V^i_n | `fold.fold`, `reflect.reflect` |
| a second bounce with J of its own, §4.3 | `second`, `second_tables`, `interleaved` |

Past the paper lights may be edited too, see `lighting`.
"""

from __future__ import annotations

from engine.methods.base import EDITS, Method
from engine.methods.brdf_editing.precompute import precompute
from engine.methods.brdf_editing.product import NAME, Polynomial
from engine.methods.brdf_editing.settings import Settings

METHOD = Method(
    name=NAME,
    paper="Ben-Artzi, Egan, Ramamoorthi, Durand 2008, A Precomputed Polynomial Representation for "
    "Interactive BRDF Editing with Global Illumination",
    edits=EDITS[NAME],
    settings=Settings,
    precompute=precompute,
)

__all__ = ["METHOD", "Polynomial", "Settings"]
