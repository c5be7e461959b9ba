"""`wavelet_brdf`: Claustres, Barthe, Paulin 2007, measured materials per pixel.

*Wavelet Encoding of BRDFs for Real-Time Rendering.* The camera, the lamps and the materials may
change; there is no indirect light. At every pixel (eq. 1)

    L_o(x, wo) = Σ_n f_r(x, wi_n, wo) I_n cos θ_n / |x - x_n|²

with f_r from a code of wavelets that is put together at a level of detail of the pixel's own, so
that from afar highlights do not sparkle.

| the paper | here |
|---|---|
| acquisition to grid, §3 | `engine.brdf.acquisition`, `engine.brdf.wavelet.tabulate` |
| transform, compression, storage, §4, §5.1, §5.2 | `engine.brdf.wavelet.encoding` |
| reconstruction, filtering, §5.3, §5.4 | `engine.brdf.wavelet.synthesis`, `levels` |
| the fragment program, §6.3 | `product`: `surface`, then lamp by lamp |

Past the paper: lamps of any kind with shadows by rays, soft ones too.
"""

from __future__ import annotations

from engine.methods.base import EDITS, Method
from engine.methods.wavelet_brdf.codes import NAME
from engine.methods.wavelet_brdf.precompute import precompute
from engine.methods.wavelet_brdf.product import Wavelets
from engine.methods.wavelet_brdf.settings import RUN_TIME, Settings

METHOD = Method(
    name=NAME,
    paper="Claustres, Barthe, Paulin 2007, Wavelet Encoding of BRDFs for Real-Time Rendering",
    edits=EDITS[NAME],
    settings=Settings,
    precompute=precompute,
    lamps_alone=True,
    run_time=RUN_TIME,
    retuned=Wavelets.retuned,
    refitted=Wavelets.refitted,
)

__all__ = ["METHOD", "Settings", "Wavelets"]
