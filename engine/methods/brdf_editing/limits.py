"""What a frame leaves out, and how much of it: the warnings of `brdf_editing`.

What depends on the scene is found when a material is taken in hand, what depends on the material in
hand in every frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import DIFFUSE
from engine.brdf.layers import LAYERS
from engine.diagnosis import Diagnosis
from engine.methods.brdf_editing.albedos import Albedos, albedo_of
from engine.methods.brdf_editing.arriving import Arriving, Surface
from engine.methods.brdf_editing.lobe_limits import (
    LATTICE,
    Lobe,
    bands_for,
    basis_error,
    half_for,
    lamp_spacing,
    lobe_of,
    points_error,
)
from engine.methods.brdf_editing.polynomial import Sent
from engine.methods.brdf_editing.settings import Settings
from engine.scene.description import TEXTURE_SLOTS
from engine.scene.scene import MaterialTable

BUDGET = 0.05  # relative error below which nothing is said
ABOVE = 0.005  # of an albedo: what its quadrature may be off
PIXELS = 2048  # that tell what gloss mirrors
MOST_KEPT = 0.99  # a room that keeps more than this of its light per bounce is not believed
MOST_BOUNCES, MOST_RAYS, MOST_EXPONENT = 8, 4096, 100_000  # of the settings
CHANNELS = "red", "green", "blue"


@dataclass(frozen=True)
class Limits:
    """What is known when a material is taken in hand.

    name      of the material, "" for none
    cut       which of LAYERS its quotients are
    taken     its row as it was then
    sent      by the cloud
    albedos   of all materials
    gloss     (3,) mean of the texture of its specular reflectance
    mirrored  (m, m): light of materials (columns) that pixels of materials (rows) may mirror
    spacing   rad: see `lamp_spacing`, of the material in hand
    said      of all others, whatever happens to that in hand
    """

    name: str
    cut: int
    taken: NDArray[np.float32]
    sent: Sent
    albedos: Albedos
    gloss: NDArray[np.float64]
    mirrored: NDArray[np.float64]
    spacing: float
    said: tuple[Diagnosis, ...]


def limits_of(
    names: Sequence[str], table: MaterialTable, hand: int, cut: int, settings: Settings,
    albedos: Albedos, gloss: NDArray[np.float64], of: NDArray[np.int32], surface: Surface,
    arriving: Arriving, sent: Sent,
) -> Limits:  # fmt: skip
    """Those of the material `hand`, -1 for none; `of` (n_g,) are the materials of the cloud."""
    shown = surface.material[: len(surface.edge)]
    apart = [
        lamp_spacing(surface, arriving.lights, np.flatnonzero(shown == m).astype(np.int32))
        if albedos[1, m].any() or m == hand
        else 0.0
        for m in range(len(names))
    ]  # fmt: skip
    said: list[Diagnosis] = []
    for m, name in enumerate(names):
        if m != hand and (shown == m).any():
            model = int(table.model[m])
            said += _of_material(name, model, table.row[m], settings, albedos[:, m], apart[m])
    if hand >= 0:
        said += _textures(names[hand], table, hand)
    albedo = albedos[:, hand].sum(axis=0) if hand >= 0 else np.zeros(3)
    mirrored = _mirrored(len(names), of, surface, arriving, albedo)
    name, spacing = (names[hand], apart[hand]) if hand >= 0 else ("", 0.0)
    taken = table.row[hand]
    return Limits(name, cut, taken, sent, albedos, gloss[hand], mirrored, spacing, tuple(said))


def warnings(
    limits: Limits, hand: int, table: MaterialTable, settings: Settings, image: NDArray[np.float32]
) -> tuple[Diagnosis, ...]:
    """What to say of a picture (n, 3) of the table, which differs in the material in hand alone."""
    even = float(image.mean() / max(1e-30, np.linalg.norm(image) / math.sqrt(image.size)))
    said, albedos, albedo = list(limits.said), limits.albedos, np.zeros((2, 3))
    if hand >= 0:
        row = table.row[hand]
        albedos = albedos.copy()
        cut = limits.cut
        albedo = albedos[:, hand] = albedo_of(cut, row, limits.taken, settings, limits.gloss)
        said += _of_material(limits.name, cut, row, settings, albedo, limits.spacing, True)
    if settings.second_bands == 1:
        said += _seen_as_matt(limits.mirrored, albedos)
    said += _truncated(limits.sent, albedo.sum(axis=0), settings.bounces, even)
    return tuple(_worst(said))


def _worst(said: Iterable[Diagnosis]) -> Iterator[Diagnosis]:
    """Of each code the largest."""
    kept: dict[str, Diagnosis] = {}
    for diagnosis in said:
        if diagnosis.code not in kept or diagnosis.size > kept[diagnosis.code].size:
            kept[diagnosis.code] = diagnosis
    return iter(kept.values())


def _of_material(
    name: str, cut: int, row: NDArray[np.float32], settings: Settings,
    albedo: NDArray[np.float64], apart: float, in_hand: bool = False,
) -> Iterator[Diagnosis]:  # fmt: skip
    """What to say of one material, of albedo (2, 3), whose lamps' points lie so far apart."""
    whole = albedo.sum(axis=0)
    channel = int(whole.argmax())
    if whole[channel] > 1 + ABOVE:
        yield Diagnosis(
            "albedo_above_one",
            f"material {name!r} reflects {whole[channel]:.2f} times the {CHANNELS[channel]} light "
            f"it receives: indirect light is too bright, {whole[channel]:.2f} times more so with "
            f"each of the {settings.bounces + 1} bounces; lower its diffuse or specular "
            "reflectance",
            float(whole[channel] - 1),
        )
    layers = LAYERS[cut]
    lobe = lobe_of(layers, row, settings) if layers is not None else None
    if lobe is None:
        return
    left = basis_error(lobe.half, settings.bands, settings.basis)
    if in_hand and left > BUDGET:
        yield Diagnosis(
            "too_sharp_for_bands",
            f"The lobe of {name!r} is {math.degrees(lobe.half):.2g} degrees wide, and "
            f"{settings.bands} {settings.basis} leave {100 * left:.0f} % of it out: set bands to "
            f"{bands_for(lobe.half, BUDGET, settings.basis)}.",
            left,
        )
    # Noise of the lobe, as a part of all that the material reflects.
    share = float(albedo[1].sum() / max(1e-9, whole.sum()))
    noise = min(1.0, share * LATTICE / max(lobe.rays, 1e-9))
    if noise > BUDGET:
        yield Diagnosis(
            "lobe_between_rays",
            f"{'Fewer than one' if lobe.rays < 1 else f'Some {lobe.rays:.0f}'} of the "
            f"{settings.view_rays} rays of a pixel fall into the lobe of {name!r}, so what it "
            f"mirrors is noisy by {100 * noise:.0f} % or more, and black where no ray falls: "
            + _more_rays(settings, lobe, share * LATTICE / lobe.rays / BUDGET),
            noise,
        )
    dots = share * points_error(lobe.half, apart)
    if dots > BUDGET:
        degrees = math.degrees(half_for(BUDGET, apart))
        yield Diagnosis(
            "lamp_seen_as_points",
            f"{name!r} mirrors a lamp so sharply that its 64 points show, "
            f"{100 * min(dots, 1):.0f} % of its mirror image: its lobe is "
            f"{math.degrees(lobe.half):.2g} degrees wide, and should be {degrees:.2g}. No setting "
            "mends it; the reference has whole lamps.",
            dots,
        )


def _more_rays(settings: Settings, lobe: Lobe, short: float) -> str:
    """What to do where so many times the rays are needed."""
    rays, advice = math.ceil(short * settings.view_rays), []
    if rays <= MOST_RAYS:
        advice.append(f"view_rays to {rays}")
    # A quarter of a cosine lobe's own exponent: half as wide again as the lobe, for its tails.
    exponent = round(math.log(2) / (4 * lobe.half**2))
    if settings.lobe_exponent < exponent <= MOST_EXPONENT:
        advice.append(f"lobe_exponent to {exponent}")
    return f"set {' or '.join(advice)}." if advice else "the reference resolves it."


def _textures(name: str, table: MaterialTable, hand: int) -> Iterator[Diagnosis]:
    layers, row = LAYERS[table.model[hand]], table.row[hand]
    assert layers is not None
    even = []
    if table.maps[hand, TEXTURE_SLOTS.index("roughness")] >= 0:
        even.append("its roughness")
    # Of Fresnel's two curves the first is textured, and not what both leave to the base.
    coupled = layers.curves > 1 and (row[DIFFUSE : DIFFUSE + 3] > 0).any()
    if coupled and table.maps[hand, TEXTURE_SLOTS.index("specular")] >= 0:
        even.append("what its gloss leaves to its base")
    if even:
        yield Diagnosis(
            "textures_left_out",
            f"While {name!r} is in hand {' and '.join(even)} stays the same everywhere. Textures "
            "are back when another material is taken in hand.",
        )


def _mirrored(
    count: int, of: NDArray[np.int32], surface: Surface, arriving: Arriving,
    albedo: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """`Limits.mirrored`: what rays of lobes meet, at some of the pixels.

    albedo (3,) is that of the material in hand, which light has met so many times.
    """
    shown = np.flatnonzero(surface.model[: len(surface.edge)] >= 0)
    some = shown[:: max(1, -(-len(shown) // PIXELS))]
    first = min(arriving.patterns.cosines, arriving.sample.shape[1] - 1)
    sample = arriving.sample[some, first:].astype(np.int64)
    met = sample < len(of)
    sample = np.where(met, sample, 0)
    pair = surface.material[some][:, None] * count + of[sample]
    times = albedo ** np.arange(arriving.powers.shape[1])[:, None]
    light = (arriving.powers * times).sum(axis=1).mean(axis=1)[sample]
    found = np.bincount(pair[met], light[met], minlength=count * count)
    return np.asarray(found, np.float64).reshape(count, count)


def _seen_as_matt(mirrored: NDArray[np.float64], albedos: Albedos) -> Iterator[Diagnosis]:
    """What to say of gloss in gloss: later bounces have the equivalent albedo alone."""
    gloss, whole = albedos[1].mean(axis=1), albedos.sum(axis=0).mean(axis=1)
    light = gloss[:, None] * mirrored
    share = float((light @ (gloss / np.maximum(whole, 1e-9))).sum() / max(light.sum(), 1e-30))
    if share > BUDGET:
        yield Diagnosis(
            "gloss_seen_as_matt",
            f"{100 * share:.0f} % of what glossy surfaces mirror is the gloss of others, which "
            "looks matt in them: up to that much is off, the more the sharper both are. Set "
            "second_bands to 8, or to 16 for caustics.",
            share,
        )


def _truncated(
    sent: Sent, albedo: NDArray[np.float64], bounces: int, even: float
) -> Iterator[Diagnosis]:
    """What to say of bounces that were not followed: a series like that of the last ones.

    What is missing lies evenly, so by the norm of a picture that does not it is less.
    """
    power = albedo ** np.arange(len(sent.total))[:, None]
    last = np.maximum((power * sent.last).sum(axis=0), 0)
    kept = np.clip(sent.kept[0] + albedo * sent.kept[1], 1e-9, MOST_KEPT)
    # The bounce that is seen comes after the last on the cloud.
    there = (power * sent.total).sum(axis=0) + kept * last
    rest = last * kept**2 / (1 - kept)
    whole = np.maximum(there + rest, 1e-30)
    size = even * float(np.linalg.norm(rest) / np.linalg.norm(whole))
    if size <= BUDGET:
        return
    worst = int((rest / whole).argmax())
    left = float(rest[worst] / max(there[worst], 1e-30))
    due = BUDGET / (1 + BUDGET) * (1 + 1 / left)
    enough = bounces + math.ceil(math.log(due) / math.log(kept[worst]))
    advice = f"set bounces to {max(enough, bounces + 1)}."
    if enough > MOST_BOUNCES:
        gone = kept[worst] ** (MOST_BOUNCES - bounces)
        still = gone / (1 + 1 / left)
        advice = f"with bounces at {MOST_BOUNCES}, the most there is, it is {100 * still:.0f} %."
    yield Diagnosis(
        "bounces_truncated",
        "Light that bounces more often than it was followed is missing, some "
        f"{100 * size:.0f} % of the picture: {advice}",
        size,
    )
