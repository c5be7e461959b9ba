"""Light that arrives straight from one light, with shadows by rays.

The same as in `engine.backend.cpu.shading`. All pictures are buffers of (n, 3) float32, and stay on
the GPU.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.penumbra import DOWN, RIGHT
from engine.backend.cpu.shading import HIDDEN, VISIBLE
from engine.backend.gl.bvh import Tree
from engine.backend.gl.context import Device
from engine.backend.gl.points import Surface
from engine.backend.gl.tables import made
from engine.light.table import LightTable

HAS_SUBSAMPLES = 4  # of a pixel's flags, beside RIGHT and DOWN of `penumbra`


class SoftPlaces(NamedTuple):
    """Places of a light with extent, each (groups, k, 2) float64; see `fixed_view.direct`.

    every, in one group, where it has no formula; wide, penumbra and lit for its part that is seen
    in a wide penumbra, in a narrow one, and by glossy pixels in full light; probes, one in a group
    """

    every: NDArray[np.float64]
    wide: NDArray[np.float64]
    penumbra: NDArray[np.float64]
    lit: NDArray[np.float64]
    probes: NDArray[np.float64]


class SoftPixels(NamedTuple):
    """What a picture with soft shadows is made by.

    flags (n,) int32  which neighbours are alike
    width             of the picture
    spare             room for (n, 4) float32
    reach             pixels each way in which somebody looks at every probe
    wide, narrow      pixels to where the weights of neighbours reach 0 in wide and narrow penumbrae
    steep             by how much of the light a wide one changes from pixel to pixel at most
    """

    flags: Any
    width: int
    spare: Any
    reach: int
    wide: int
    narrow: int
    steep: float


class Shading:
    """Lights the points of one scene."""

    def __init__(self, device: Device, tree: Tree, epsilon: float) -> None:
        """The tree is uploaded; rays start `epsilon` metres off their surface."""
        self._device, self._epsilon = device, epsilon
        self._tree = {
            "b_nodes": device.upload(tree.nodes),
            "b_corners": device.upload(tree.corners),
        }
        self._texels: tuple[NDArray[np.float32], Any] | None = None

    def points(
        self,
        surface: Surface,
        table: LightTable,
        samples: NDArray[np.float64],
        radiance: Any,
        visible: Any,
    ) -> None:
        """Fill radiance, and visible (n,) int32, of the one light of a table.

        samples (groups, k, 2) as for the CPU's `light_points`.
        """
        buffers = {"b_radiance": radiance, "b_visible": visible}
        self._run("light_points", surface.count, surface, table, samples, buffers,
                  u_count=surface.count)  # fmt: skip

    def soft(
        self,
        surface: Surface,
        table: LightTable,
        places: SoftPlaces,
        pixels: SoftPixels,
        radiance: Any,
    ) -> None:
        """Fill radiance of a light with extent; see `_soft_light` of `fixed_view.direct`."""
        n, width = surface.count, pixels.width
        visible, near, around, steep, narrow, by = (self._device.room(4 * n) for _ in range(6))
        seen, part, spare = (self._device.room(8 * n) for _ in range(3))
        named = {
            "b_flags": pixels.flags, "b_visible": visible, "b_near": near, "b_around": around,
            "b_steep": steep, "b_narrow": narrow, "b_by": by, "b_seen": seen, "b_part": part,
            "b_radiance": radiance,
        }  # fmt: skip
        # All places in one buffer; of each kind the first, groups, and places in each.
        kinds = places.every, places.wide, places.penumbra, places.lit
        samples = np.concatenate([kind.reshape(-1, 2) for kind in kinds])[None]
        ends = np.cumsum([0, *(kind.shape[0] * kind.shape[1] for kind in kinds)]).tolist()
        every, wide, penumbra, lit = (
            (end, *kind.shape[:2]) for end, kind in zip(ends, kinds, strict=False)
        )

        def light(name: str, samples: NDArray[np.float64] = samples, **uniforms: Any) -> None:
            self._run(name, n, surface, table, samples, named, u_count=n, **uniforms)

        def run(name: str, buffers: dict[str, Any], **uniforms: Any) -> None:
            program = self._device.program(f"passes/{name}.glsl")
            program.run(n, {**named, **buffers}, u_count=n, **uniforms)

        def dilate(marks: Any, kept: Any, found: Any, mark: int, least: int, reach: int) -> None:
            buffers = {"b_marks": marks, "b_kept": kept, "b_found": found}
            run("soft_around", buffers, u_width=width, u_reach=reach, u_mark=mark, u_kept=least)

        def mean(target: Any, reach: int) -> None:
            across, down = ((seen, spare), (spare, target))
            for (source, end), step, way in ((across, 1, RIGHT), (down, width, DOWN)):
                buffers = {"b_source": source, "b_target": end}
                run("soft_mean", buffers, u_step=step, u_way=way, u_reach=reach)

        light("soft_probe", places.probes)
        light("light_soft", u_width=width, u_reach=pixels.reach, u_lit=lit, u_penumbra=penumbra,
              u_wide=wide)  # fmt: skip
        smooth_penumbrae(self._device, surface, pixels.flags, width, radiance, pixels.spare)
        dilate(near, near, around, HIDDEN | VISIBLE, 0, pixels.wide)
        mean(part, pixels.wide)
        run("soft_steep", {}, u_width=width, u_steep=pixels.steep)
        dilate(steep, around, narrow, 1, 1, pixels.wide)
        dilate(narrow, around, by, 1, 1, pixels.narrow)
        light("soft_again", u_penumbra=penumbra)
        mean(seen, pixels.narrow)
        light("soft_light", u_every=every[2])

    def fine(
        self,
        surface: Surface,
        table: LightTable,
        samples: NDArray[np.float64],
        listed: Any,
        radiance: Any,
        eye: tuple[float, float, float],
        width: int,
        offsets: NDArray[np.float64],
    ) -> None:
        """Fill radiance anew at the pixels that `light_ends` has listed.

        Each is the mean over a grid of places, offsets (k, 2) in pixels.
        """
        buffers = {
            "b_list": listed,
            "b_radiance": radiance,
            "b_offsets": self._device.upload(offsets.astype(np.float32)),
        }
        self._run("light_fine", surface.count, surface, table, samples, buffers,
                  u_count=surface.count, u_width=width, u_eye=tuple(eye))  # fmt: skip

    def sub(
        self,
        surface: Surface,
        table: LightTable,
        samples: NDArray[np.float64],
        edge: Any,
        radiance: Any,
    ) -> None:
        """Fill radiance at the pixels of edge (m,) int32, each the mean over four points."""
        edges = surface.count // 4
        buffers = {"b_edge": edge, "b_radiance": radiance}
        self._run("light_sub", edges, surface, table, samples, buffers, u_edges=edges)

    def lamp(
        self,
        surface: Surface,
        table: LightTable,
        eye: tuple[float, float, float],
        width: int,
        outline: NDArray[np.float64] | None,
        shown: Any,
        total: Any,
    ) -> None:
        """Lay what the camera sees of a light with extent itself over a picture.

        outline (k, 2) are places in a pixel, for those where the lamp ends; None for no more than
        one place anywhere. shown has room for (n, 4) float32.
        """
        places = np.zeros((1, 2)) if outline is None else outline
        buffers = {
            "b_points": surface.buffer,
            "b_light": self._device.upload(table.row[0]),
            "b_offsets": self._device.upload(places.astype(np.float32)),
            "b_shown": shown,
            "b_sum": total,
        }
        for name in ("lamp_centres", "lamp_show"):
            program = self._device.program(f"passes/{name}.glsl", made=_made(int(table.kind[0])))
            program.run(
                surface.count, buffers, u_count=surface.count, u_width=width, u_eye=tuple(eye),
                u_fine=int(outline is not None),
            )  # fmt: skip

    def _run(
        self,
        name: str,
        items: int,
        surface: Surface,
        table: LightTable,
        samples: NDArray[np.float64],
        buffers: dict[str, Any],
        **uniforms: Any,
    ) -> None:
        groups, per_point = samples.shape[:2]
        program = self._device.program(f"passes/{name}.glsl", made=_made(int(table.kind[0])))
        program.run(
            items,
            {
                **self._tree,
                **buffers,
                "b_points": surface.buffer,
                "b_light": self._device.upload(table.row[0]),
                "b_samples": self._device.upload(samples.astype(np.float32)),
                "b_texels": self._images(table.texels),
            },
            u_epsilon=self._epsilon, **{"u_groups": groups, "u_per_point": per_point, **uniforms},
        )  # fmt: skip

    def _images(self, texels: NDArray[np.float32]) -> Any:
        """The buffer of a light's image, which is sent again only when it is another."""
        if self._texels is None or self._texels[0] is not texels:
            self._texels = texels, self._device.upload(texels)
        return self._texels[1]


_made = cache(made)


def light_ends(device: Device, visible: Any, flags: Any, width: int, n: int, listed: Any) -> None:
    """List the pixels where light ends, but for those with HAS_SUBSAMPLES, in no certain order.

    visible, flags (n,) int32; listed has room for 1 + n int32, the first is their number.
    """
    device.write(listed, bytes(4))
    buffers = {"b_visible": visible, "b_flags": flags, "b_list": listed}
    program = device.program("passes/light_ends.glsl")
    program.run(n, buffers, u_count=n, u_width=width)


def smooth_penumbrae(
    device: Device, surface: Surface, flags: Any, width: int, radiance: Any, spare: Any
) -> None:
    """Average what arrives over the 3 x 3 around each pixel, in place; `spare` is a picture."""
    program = device.program("passes/penumbra.glsl")
    for source, target, step, way in (
        (radiance, spare, 1, RIGHT),
        (spare, radiance, width, DOWN),
    ):
        buffers = {
            "b_points": surface.buffer, "b_flags": flags, "b_source": source, "b_target": target
        }  # fmt: skip
        program.run(surface.count, buffers, u_count=surface.count, u_step=step, u_way=way)
