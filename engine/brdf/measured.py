"""A measured material: a file of samples, completed to a grid and encoded by wavelets.

`engine.brdf.acquisition` reads and completes it, `engine.brdf.wavelet` encodes it (Claustres,
Barthe, Paulin 2007). A row holds the key under which the block of the code is filed, see
`engine.brdf.library`, and in the place of the specular reflectance a colour that multiplies it.
At LEVEL is the level of detail, 0 for the finest; a broken one lies between two. Where there is a 1
at NEAREST, values are not interpolated between directions. Nothing but the measurement keeps its
albedo below 1.
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numba import cfunc, njit
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr

from engine.brdf import library
from engine.brdf.base import EXTRA, GRAIN, Material, seen_turned, specular_colour
from engine.brdf.wavelet import layout, sampling
from engine.brdf.wavelet.encoding import DEFAULT, Encoded, Target, encode
from engine.brdf.wavelet.synthesis import ZERO, levels, synthesise
from engine.brdf.wavelet.tabulate import BITS, Source, grid_for, tabulate
from engine.errors import InputError, SceneError
from engine.numerics.description import Reflectance
from engine.numerics.far_call import SIGNATURE, call
from engine.numerics.memory import float32_at, store_double
from engine.numerics.vec import mul

if TYPE_CHECKING:
    from engine.brdf.acquisition import Measurement

KEPT = 64
KEY = EXTRA  # two places
LEVEL = EXTRA + 2
NEAREST = EXTRA + 3
BUILT_IN = ("plastic", "brushed", "threads")  # see `engine.brdf.built_in`


class Measured(Material):
    """Whatever somebody has measured: paint, cloth, wood."""

    gloss_is_linear = True
    type: Literal["measured"] = "measured"
    specular: Annotated[Reflectance, Field(description="colour that multiplies all of it")] = (
        1.0,
        1.0,
        1.0,
    )
    file: Annotated[
        str,
        Field(
            min_length=1,
            max_length=1024,
            description="a file beside the scene (.brdf, .binary, .csv), or "
            + ", ".join(repr(name) for name in BUILT_IN),
        ),
    ] = BUILT_IN[0]

    _measurement: Measurement | None = PrivateAttr(None)

    def located(self, folder: Path) -> Self:
        """See `Material.located`."""
        material = self.model_copy()
        material._measurement = _read(self.file, folder)
        return material

    def measurement(self) -> Measurement:
        """What was measured; a file that `located` has not read is looked for where we run."""
        return self._measurement or _read(self.file, Path())

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`; then the key. One with a grain has it along the local x axis."""
        row = self._fill((0.0, 0.0, 0.0), self.specular)
        fill(row, encoded(self.measurement()))
        return row


def fill(row: NDArray[np.float32], encoded: Encoded) -> None:
    """Write the key of a code, and its grain along the local x axis if it has one, into a row."""
    _install()
    row[KEY : KEY + 2] = library.file(encoded.data)
    row[GRAIN] = encoded.grid.symmetry != layout.ISOTROPIC


def _read(file: str, folder: Path) -> Measurement:
    if file in BUILT_IN:
        return _built_in(file)
    path = folder / file
    # Not by `Path.is_file`, which raises for a name that is too long.
    if not os.path.isfile(path):
        known = ", ".join(BUILT_IN)
        raise SceneError(
            f"there is no such file, and built-in materials are: {known}", field="file", file=file
        )
    try:
        return _in_file(path, path.stat().st_mtime_ns)
    except InputError as error:
        where = f"{error.field}: " if error.field else ""
        raise SceneError(f"{where}{error.message}", field="file", file=file) from None
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", field="file", file=file) from None


# Whatever is measured may be a model of the table, which holds this module too: hence the imports.
@lru_cache(KEPT)
def _built_in(name: str) -> Measurement:
    from engine.brdf.built_in import measured

    return measured(name)


@lru_cache(KEPT)
def _in_file(path: Path, modified: int) -> Measurement:
    """`modified` makes a file that has changed another one."""
    from engine.brdf.acquisition import read

    return read(path)


def encoded(source: Source, bits: int = BITS, target: Target = DEFAULT) -> Encoded:
    """The code of anything that can be evaluated; see `grid_for` and `Target`. Kept for a while."""
    return _encoded(source, bits, target)  # type: ignore[arg-type]


@lru_cache(KEPT)
def _encoded(source: Source, bits: int, target: Target) -> Encoded:
    grid = grid_for(source, bits)
    return encode(tabulate(source, grid), grid, target)


@njit
def _in_grain(grain, w):
    """w along a grain (cosine, sine), or as it is where there is none."""
    c, s = grain
    return seen_turned(c, s, w) if c != 0.0 or s != 0.0 else w


@njit
def at_level(a, wi, wo, level, nearest=False):
    """Between two levels where it is broken (§5.4.1); `a` is the address of a block."""
    coarse = min(int(level), levels(a) - 1)
    r, g, b = synthesise(a, wi, wo, coarse, nearest)
    part = level - coarse
    if part > 0.0 and coarse < levels(a) - 1:
        there = synthesise(a, wi, wo, coarse + 1, nearest)
        r, g, b = r + part * (there[0] - r), g + part * (there[1] - g), b + part * (there[2] - b)
    return r, g, b


# What every kernel calls and none compiles anew; `row` and `found` are addresses.
@njit
def _code_of(row):
    """(address of the block of a row or 0, its grain)."""
    a = library.find(float32_at(row, KEY), float32_at(row, KEY + 1))
    return a, (float32_at(row, GRAIN), float32_at(row, GRAIN + 1))


@njit
def _write(found, x, y, z):
    store_double(found, 0, x)
    store_double(found, 1, y)
    store_double(found, 2, z)


def _evaluate(row, ix, iy, iz, ox, oy, oz, found):
    """Find f without the colour."""
    a, grain = _code_of(row)
    f = ZERO, ZERO, ZERO
    if a != 0:
        wi, wo = _in_grain(grain, (ix, iy, iz)), _in_grain(grain, (ox, oy, oz))
        f = at_level(a, wi, wo, float32_at(row, LEVEL), float32_at(row, NEAREST) != ZERO)
    _write(found, f[0], f[1], f[2])


def _sample(row, ox, oy, oz, u1, u2, u3, found):
    """Find an incident direction."""
    a, grain = _code_of(row)
    w = 0.0, 0.0, 0.0
    if a != 0:
        w = sampling.sample(a, _in_grain(grain, (ox, oy, oz)), (u1, u2, u3))
        w = _in_grain((grain[0], -grain[1]), w)
    _write(found, w[0], w[1], w[2])


def _pdf(row, ix, iy, iz, ox, oy, oz, found):
    """Find a density, and zeros."""
    a, grain = _code_of(row)
    density = 0.0
    if a != 0:
        wi, wo = _in_grain(grain, (ix, iy, iz)), _in_grain(grain, (ox, oy, oz))
        density = sampling.pdf(a, wi, wo)
    _write(found, density, 0.0, 0.0)


EVALUATE, SAMPLE, PDF = range(3)
_functions: list[Any] = []


def _install() -> None:
    """Compile the functions, or load them; from then on kernels find them."""
    if not _functions:
        _functions.extend(cfunc(SIGNATURE, cache=True)(f) for f in (_evaluate, _sample, _pdf))
        library.install(*(function.address for function in _functions))


@njit
def evaluate(p, wi, wo):
    """The code at the row's level, times the colour."""
    function = library.function(EVALUATE)
    if wi[2] <= 0.0 or wo[2] <= 0.0 or function == 0:
        return (0.0, 0.0, 0.0)
    return mul(specular_colour(p), call(function, p, wi, wo))


@njit
def sample(p, wo, u):
    """See `wavelet.sampling`."""
    function = library.function(SAMPLE)
    if wo[2] <= 0.0 or function == 0:
        return (0.0, 0.0, 0.0)
    return call(function, p, wo, u)


@njit
def pdf(p, wi, wo):
    """See `wavelet.sampling`."""
    function = library.function(PDF)
    if wi[2] <= 0.0 or wo[2] <= 0.0 or function == 0:
        return 0.0
    return call(function, p, wi, wo)[0]
