"""Direct-to-indirect transfer: any light may move, camera, geometry and materials stand.

Hašan, Pellacini, Bala 2006, *Direct-to-Indirect Transfer for Cinematic Relighting*.

    v_d = k_d * (F_d (M + I) g_d)                     eq. 5: matt part of a view sample
    v_g = k_g * (F_g (M + I) g_d)                     eq. 6: glossy part
    v   = k * (F^w W (M^w W + I) g_d)                 eq. 7, 8: rows of F and M in wavelet space
    d(s, c) = K² |p_s - p_c|² + D² |n_s - n_c|²       eq. 9: distance for the cluster tree

| paper | here | what |
|---|---|---|
| V | `View.buffer.centre` | view samples, one per pixel |
| G, n_g | `GatherCloud` | gather samples, a power of four |
| g_d | `g` | direct radiance of the gather samples, reflected diffusely |
| F_d, F_g | `Transfer.final`, `Transfer.gloss` | final gather, scalar |
| M | `Bounces`, `Transfer.bounce` | bounces within the cloud, one at a time |
| W | `engine.numerics.haar` | Haar transform on the cluster tree |
| k_d, k_g | `View.reflectance` / π | what a view sample does with what it gathers |
| K, D | `position_weight`, `Scene.diagonal` | weights of eq. 9 |

Where we leave the paper: M is applied bounce by bounce (scalar rows, any number of bounces, no
photon noise), what culling takes from a bounce is given back (`bounces`), and light that stays
when lights move, of emission and environment, is bounced by itself (`standing`); rows come from
rays that land on gather samples (`fixed_view.gather_rays`), with the paper's links as a setting,
whose form factors are those of disks (no clamp in corners); 64 neighbouring rows share their list
of wavelets, and what they have in common is stored once (`fixed_view.packing`). Wavelet lights are
not culled at run time: see `backend.cpu.product`. Frames are drawn by `product` on the CPU, by
`gl_transfer` on the GPU.
"""

from engine.methods.base import EDITS, Method
from engine.methods.direct_to_indirect.precompute import precompute
from engine.methods.direct_to_indirect.product import NAME, Transfer
from engine.methods.direct_to_indirect.settings import Settings

METHOD = Method(
    name=NAME,
    paper="Hašan, Pellacini, Bala 2006, Direct-to-Indirect Transfer for Cinematic Relighting",
    edits=EDITS[NAME],
    settings=Settings,
    precompute=precompute,
)

__all__ = ["METHOD", "Settings", "Transfer"]
