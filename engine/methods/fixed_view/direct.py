"""Direct light on the deep frame-buffer and on the gather cloud, one light at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.penumbra import changes_fast, mean_seen, smooth_penumbrae
from engine.backend.cpu.shading import (
    HIDDEN,
    VISIBLE,
    average,
    light_edges,
    light_points,
    on_tangent_planes,
    seen_around,
)
from engine.backend.cpu.soft import look, unshadowed
from engine.light.base import Light
from engine.light.table import LightTable, light_table
from engine.methods.fixed_view.frame_buffer import FINE, FrameBuffer, Points
from engine.scene.rays import RayTracer

# A light with extent shines from an 8 x 8 grid of its points. No point of a surface asks all of
# them: neighbours ask different ones, and in a picture they are averaged afterwards. PER_PIXEL is
# for glossy pixels in full light.
PER_PIXEL, PER_SUBSAMPLE, PER_PENUMBRA_PIXEL, PER_COARSE_PENUMBRA_PIXEL = 2, 4, 16, 8
PER_WIDE_PENUMBRA_PIXEL = 4
CENTRE = np.full((1, 1, 2), 0.5)  # of a light without extent
BLOCK = 4  # pixels that share a pattern of `light_samples`
POINTS_ON_GLOSS = BLOCK * PER_PIXEL  # in full light, once neighbours are averaged
# Pixels each way in which somebody looks at every one of PROBES.
PROBE_REACH = 2
# Pixels to where the weights of neighbours reach 0, in penumbrae that change by less than STEEP of
# the light from pixel to pixel, and in others: the sides of the blocks that see all 64 points.
# Steeper, the wide tent would blur: at 1/24 no lamp of nine in the Cornell box is less accurate.
WIDE, NARROW = 4, 2
STEEP = 1 / 24


def probes() -> NDArray[np.float64]:
    """(16, 1, 2): from which point of a light a pixel looks for what hides it, by its phase.

    An even grid that goes up to the rim: the last of a light to go, and the first to come, is its
    end. Every block of 2 x 2 pixels holds a corner, two points of sides, and one within.
    """
    phase = np.arange(16)
    place = np.stack([phase & 1, phase >> 1 & 1]), np.stack([phase >> 2 & 1, phase >> 3 & 1])
    spread = np.where(place[0] == 0, place[1], (1 + place[1]) / 3)
    return np.ascontiguousarray(spread.T[:, None], np.float64)  # as `light_samples` are


def light_samples(light: Light, per_point: int) -> NDArray[np.float64]:
    """(groups, k, 2) sample points of a light: one, or a grid in groups of `per_point`.

    The grid is in the order of Sobol's (0, 2)-sequence: of any four in a row one lies in each
    quarter of the light, of any sixteen one in each sixteenth, of any eight one in each row and
    column. The lowest digit of y is flipped in half of the rows, by which x and y of the first
    eight and sixteen are uncorrelated, so that those few average any quadratic almost exactly.
    """
    if not light.has_extent:
        return CENTRE
    bit = np.arange(64)[:, None] >> np.arange(6) & 1
    x = bit[:, :3] @ (4, 2, 1)
    a, b, c = bit.sum(axis=1), bit[:, 1::2].sum(axis=1), bit[:, 2] + bit[:, 3]
    y = 4 * (a % 2) + 2 * (b % 2) + (a + b + c + 1) % 2
    return ((np.stack([x, y], axis=1) + 0.5) / 8).reshape(-1, per_point, 2)


def light_on_points(rays: RayTracer, points: Points, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of one light, from one of its points for each of ours.

    Not by the formula of a whole light: times one ray, or four, that is less noisy, but a tenth too
    dark where what is seen of it gives more than its share.
    """
    return _light(rays, points, light, light_samples(light, 1))[0]


def light_from_each(rays: RayTracer, points: Points, light: Light) -> NDArray[np.float32]:
    """Radiance (n, 64, 3) float32 that each point reflects of each of a light's, were it whole.

    Nothing hides them. In the order of `light_samples`.
    """
    samples = light_samples(light, 1)
    every = points.take(np.repeat(np.arange(len(points)), len(samples)))
    every.phase[:] = np.tile(np.arange(len(samples), dtype=np.uint8), len(points))
    at = np.arange(len(every), dtype=np.int32)
    found, _ = _light(rays, every, light, samples, at, every.position, shadows=False)
    return found.reshape(len(points), len(samples), 3)


def light_on_pixels(
    rays: RayTracer, points: Points, alike: NDArray[np.uint8], width: int, light: Light
) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of one light on a picture so wide, not antialiased.

    alike (n,) is from `alike_neighbours`.
    """
    if light.has_extent:
        return _soft_light(rays, points, alike, width, light, PER_COARSE_PENUMBRA_PIXEL)
    return _light(rays, points, light, CENTRE)[0]


def light_on_buffer(rays: RayTracer, buffer: FrameBuffer, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 per pixel, antialiased as if four times supersampled."""
    radiance = light_on_centres(rays, buffer, light)
    average(buffer.edge, light_on_subsamples(rays, buffer, light), radiance)
    return radiance


def light_on_centres(rays: RayTracer, buffer: FrameBuffer, light: Light) -> NDArray[np.float32]:
    """The same of the surfaces in the pixels' centres (n, 3): only shadows are antialiased."""
    centre, width = buffer.centre, buffer.camera.width
    if light.has_extent:
        return _soft_light(rays, centre, buffer.alike, width, light, PER_PENUMBRA_PIXEL)
    radiance, visible = _light(rays, centre, light, CENTRE)
    skip = np.zeros(len(centre), np.bool_)
    skip[buffer.edge] = True
    # Where light ends within a pixel, light its tangent plane at a finer grid of places.
    pixel = light_edges(visible, skip, width)
    places = on_tangent_planes(
        pixel, buffer.camera.position, centre.view, centre.position, centre.geometric, width, FINE
    )
    fine, _ = _light(rays, centre, light, CENTRE, np.repeat(pixel, len(FINE)), places)
    average(pixel, fine, radiance)
    return radiance


def light_on_subsamples(rays: RayTracer, buffer: FrameBuffer, light: Light) -> NDArray[np.float32]:
    """The same of the four sub-samples of each edge pixel (4m, 3)."""
    return _light(rays, buffer.sub, light, light_samples(light, PER_SUBSAMPLE))[0]


def seen_nearby(
    rays: RayTracer, points: Points, width: int, table: LightTable
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """What one ray from each pixel of a picture so wide tells of the one light with extent.

    (n, 2) float32: what each finds, see `look`; (n,) uint8: HIDDEN, VISIBLE or both, for what all
    within PROBE_REACH find.
    """
    every = np.arange(len(points), dtype=np.int32)
    seen, visible = _look(rays, points, table, every, probes())
    return seen, seen_around(visible, width, PROBE_REACH)


def _soft_light(
    rays: RayTracer,
    points: Points,
    alike: NDArray[np.uint8],
    width: int,
    light: Light,
    per_penumbra: int,
) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of a light with extent on a picture so wide.

    One ray in every pixel tells where all of the light is seen, none of it, or some: there are up
    to `per_penumbra` of them, and in full light none more.
    """
    n = len(points)
    out = np.zeros((n, 3), np.float32)
    table = light_table([light])
    if not len(table.kind):
        return out
    seen, near = seen_nearby(rays, points, width, table)

    # Matt surfaces: what the light gives, times the part of it that is seen.
    penumbra = (near == HIDDEN | VISIBLE) & points.matt
    spread = seen_around(penumbra.view(np.uint8), width, WIDE - 1) > 0
    pixel = np.flatnonzero((spread | (near == VISIBLE)) & points.matt).astype(np.int32)
    part = _part_seen(
        rays, points, alike, width, light, table, per_penumbra, seen, penumbra, spread
    )
    out[pixel] = _unshadowed(points, light, table, pixel) * part[pixel, None]

    # Glossy ones: samples.
    glossy = ~points.matt & (points.model >= 0)
    if glossy.any():
        out[glossy] = _soft_light_by_samples(
            rays, points, alike, width, light, per_penumbra, np.where(glossy, near, 0)
        )[glossy]
    return out


def _part_seen(
    rays: RayTracer,
    points: Points,
    alike: NDArray[np.uint8],
    width: int,
    light: Light,
    table: LightTable,
    per_penumbra: int,
    seen: NDArray[np.float32],
    penumbra: NDArray[np.bool_],
    spread: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """(n,) float32: which part of a light each pixel sees, 1 where it is not in or by a penumbra.

    seen (n, 2) is what one ray from each found. Four rays in each pixel of a penumbra (n,) bool are
    enough where it is wide, averaged over the pixels around, which it is spread to. Where it is
    narrow there are `per_penumbra`, averaged over fewer pixels.
    """
    part = np.ones(len(points), np.float32)
    pixel = np.flatnonzero(penumbra).astype(np.int32)
    seen[pixel], _ = _look(
        rays, points, table, pixel, light_samples(light, PER_WIDE_PENUMBRA_PIXEL)
    )
    around = np.flatnonzero(spread & points.matt).astype(np.int32)
    part[around] = mean_seen(seen, around, around, alike, width, WIDE)

    narrow = np.zeros(len(points), np.bool_)
    narrow[around] = changes_fast(part, around, alike, width, STEEP)
    # A narrow penumbra, too, starts and ends gently.
    narrow = (seen_around(narrow.view(np.uint8), width, WIDE - 1) > 0) & spread & points.matt
    near = penumbra & (seen_around(narrow.view(np.uint8), width, NARROW - 1) > 0)
    again = np.flatnonzero(near).astype(np.int32)
    samples = light_samples(light, per_penumbra)[:BLOCK]
    seen[again], _ = _look(rays, points, table, again, samples)
    pixel = np.flatnonzero(narrow).astype(np.int32)
    part[pixel] = mean_seen(seen, pixel, around, alike, width, NARROW)
    return part


def _soft_light_by_samples(
    rays: RayTracer,
    points: Points,
    alike: NDArray[np.uint8],
    width: int,
    light: Light,
    per_penumbra: int,
    near: NDArray[np.uint8],
) -> NDArray[np.float32]:
    """The same whatever surfaces reflect; near (n,) uint8 is what is seen around each pixel."""
    out = np.zeros((len(points), 3), np.float32)
    for here, per_pixel, shadows in (
        (near == VISIBLE, PER_PIXEL, False),
        (near == HIDDEN | VISIBLE, per_penumbra, True),
    ):
        pixel = np.flatnonzero(here).astype(np.int32)
        samples, places = light_samples(light, per_pixel)[:BLOCK], points.position[pixel]
        out[pixel], _ = _light(rays, points, light, samples, pixel, places, shadows)
    return smooth_penumbrae(out, points.row, alike, width)


def _look(
    rays: RayTracer,
    points: Points,
    table: LightTable,
    at: NDArray[np.int32],
    samples: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    return look(
        rays, at, points.position, points.normal, points.geometric, points.model, points.row,
        points.phase, points.size, table, samples,
    )  # fmt: skip


def _unshadowed(
    points: Points, light: Light, table: LightTable, at: NDArray[np.int32]
) -> NDArray[np.float32]:
    return unshadowed(
        at, points.position, points.normal, points.geometric, points.view, points.row, points.size,
        table, light_samples(light, 64)[0],
    )  # fmt: skip


def _light(
    rays: RayTracer,
    points: Points,
    light: Light,
    samples: NDArray[np.float64],
    at: NDArray[np.int32] | None = None,
    position: NDArray[np.float32] | None = None,
    shadows: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """`light_points` at all points, or at other positions on the surface of some of them."""
    if at is None or position is None:
        at, position = np.arange(len(points), dtype=np.int32), points.position
    table = light_table([light])
    if not len(table.kind):
        return np.zeros((len(at), 3), np.float32), np.zeros(len(at), np.uint8)
    return light_points(
        rays, at, position, points.normal, points.geometric, points.view, points.model, points.row,
        points.phase, points.size, table, samples, shadows,
    )  # fmt: skip
