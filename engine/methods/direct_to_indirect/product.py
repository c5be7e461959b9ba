"""The finished transfer and the frames that it makes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend, GlFirst
from engine.backend.cpu.product import multiply
from engine.backend.gl.context import Device
from engine.diagnosis import Diagnosis
from engine.light.base import Light
from engine.light.environment import Environment
from engine.methods.base import Frame, MaterialFit, require_supported
from engine.methods.clock import Clock
from engine.methods.direct_to_indirect.bounces import Bounced, Bounces
from engine.methods.direct_to_indirect.coverage import said_of, uncovered
from engine.methods.direct_to_indirect.gl_transfer import GlTransfer, Parts, Standing
from engine.methods.direct_to_indirect.gloss_limits import Caustics
from engine.methods.direct_to_indirect.light_balance import LightBalance
from engine.methods.direct_to_indirect.mirrored_lamps import MirroredLamps
from engine.methods.direct_to_indirect.mirrors import blurred_mirrors, mirrored_by, seen_as_matt
from engine.methods.direct_to_indirect.reflected import (
    add_at_edges,
    add_indirect,
    as_gathered,
    glossy_pixels,
)
from engine.methods.direct_to_indirect.settings import Settings
from engine.methods.direct_to_indirect.standing import StandingLight, both
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.environment_light import EnvironmentLight, EnvironmentRows
from engine.methods.fixed_view.nearest import build_grid
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import coarse_tiles, pixel_tiles
from engine.methods.fixed_view.view import Reflectance, View
from engine.numerics import haar
from engine.scene.edits import Edits, edited_environment, edited_lights

NAME = "direct_to_indirect"


class Drawn(NamedTuple):
    """A picture, and what there is to say about it.

    image         (n, 3)
    missing       what the bounces may miss of all light
    later         part of what the cloud reflects that has bounced before
    first         () -> (n_g, 3), what the cloud reflects of all lights first
    first_of      light -> (n_g, 3), the same of one light
    timings       seconds by part
    """

    image: NDArray[np.float32]
    missing: float
    later: float
    first: Callable[[], NDArray[np.float32]]
    first_of: Callable[[Light], NDArray[np.float32]]
    timings: dict[str, float]


class Transfer:
    """v = (k_d * F_d + k_g * F_g) (I + M) g, all in wavelet space (eq. 2, 5 to 8)."""

    def __init__(
        self,
        view: View,
        settings: Settings,
        cloud: GatherCloud,
        bounce: PackedRows,
        final: PackedRows,
        gloss: PackedRows,
        environment: EnvironmentRows,
    ) -> None:
        """Final and gloss rows are those of `pixel_tiles`, bounce rows those of `run_tiles`."""
        self.view, self._settings, self.cloud = view, settings, cloud
        self.bounce, self.final, self.gloss = bounce, final, gloss
        self.environment = environment
        camera = view.scene.camera
        self._tiles = {
            1: pixel_tiles(camera.width, camera.height),
            2: coarse_tiles(camera.width, camera.height),
        }
        self._reflects = len(gloss.ids) + len(environment.gloss.ids) > 0
        self._environment = EnvironmentLight(cloud, environment, self._tiles)
        self._bounces = Bounces(view.scene, cloud, bounce, settings.bounces, settings.seed)
        self._bounced = StandingLight(self._bounces, cloud, self._environment)
        points = cloud.points
        nearby = build_grid(points.position, points.geometric, cloud.area)
        self._balance = LightBalance(view.scene, cloud, nearby)
        # Indirect light meets whole pixels where they have no sub-samples.
        self._glossy = glossy_pixels(view)
        self._caustics = Caustics(view.scene, cloud)
        self._lamps = MirroredLamps(view, self._glossy)
        mirrored = mirrored_by(view, self._glossy)
        self._of_view = (
            blurred_mirrors(mirrored, cloud),
            seen_as_matt(mirrored),
        )
        self._uncovered = uncovered(view, cloud, nearby)
        whole = as_gathered(view.reflectance, self._glossy)
        self._sub = as_gathered(view.sub_reflectance, self._glossy[view.buffer.donor])
        grid = np.arange(len(whole.matt)).reshape(camera.height, camera.width)
        coarse = grid[::2, ::2].ravel()
        self._reflectance = {2: Reflectance(*(part[coarse] for part in whole)), 1: whole}
        for part in whole:
            part[view.buffer.edge] = 0
        self._backend = GlFirst()
        # The same on the GPU, from the first frame that it draws.
        self._gl: GlTransfer | None = None

    @property
    def method(self) -> str:
        """`direct_to_indirect`."""
        return NAME

    @property
    def settings(self) -> Settings:
        """What it was made with."""
        return self._settings

    @property
    def bytes(self) -> int:
        """Bytes of the matrices, all that a frame reads of the transport."""
        matrices = (self.final, self.gloss, self.bounce, *self.environment)
        return sum(array.nbytes for rows in matrices for array in rows)

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """None: materials are taken as they are."""
        return ()

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """See `engine.methods.base.Product.relight`."""
        require_supported(NAME, edits)
        lights, environment = self._edited(edits)
        drawn, notices = self._backend.draw(
            backend,
            lambda device: self._by_gl(device, lights, environment, scale),
            lambda: self._by_cpu(lights, environment, scale),
        )
        if self._backend.failed:
            self._gl = None
        start, timings = time.perf_counter(), drawn.timings
        warnings = (*notices, *self._warnings(lights, environment, drawn, scale))
        timings["diagnosis"] = time.perf_counter() - start
        timings["total"] += timings["diagnosis"]
        height, width = self.view.shape(scale)
        return Frame(drawn.image.reshape(height, width, 3), timings, warnings)

    def _by_gl(
        self,
        device: Device,
        lights: tuple[Light, ...],
        environment: Environment | None,
        scale: int,
    ) -> Drawn:
        """The picture by the GPU. Raises BackendError where it fails."""
        clock = Clock(device.context.finish)
        gl = self._gl = self._gl or GlTransfer(device, self._parts())
        with clock("environment"):
            standing = self._standing(environment, scale)
        image, powers = gl.draw(lights, standing, scale, clock)
        bounced = self._bounced(environment)
        of_lights = self._bounces.weighed(powers, self._bounces.of_lights)
        bounced = both(bounced, Bounced(np.zeros_like(bounced.total), *of_lights))
        missing = bounced.unsure / max(bounced.power, 1e-30)
        return Drawn(image, missing, bounced.later, gl.first, gl.first_of, clock.timings())

    def _standing(self, environment: Environment | None, scale: int) -> Standing:
        backdrop = self.view.backdrop.picture(environment)
        if environment is None:
            return Standing(backdrop, self._bounced(None).total)
        light, n = self._environment, len(self.view.points(scale))
        light.use(environment)
        bounced = self._bounced(environment).total
        return Standing(backdrop, bounced, *light.view(scale, n), light.suns)

    def _by_cpu(
        self, lights: tuple[Light, ...], environment: Environment | None, scale: int
    ) -> Drawn:
        clock = Clock()
        view = self.view
        if environment is not None:
            with clock("environment"):
                self._environment.use(environment)
                self._bounced(environment)
        suns = self._environment.suns if environment is not None else ()

        # Direct light on gather samples: g.
        with clock("gather_direct"):
            g = self._on_cloud(lights + suns)

        # Bounces within the cloud: (I + P + ... + P^b) g, from here on in wavelet space.
        with clock("bounces"):
            bounced = self._bounced(environment)
            if g.any():
                bounced = both(bounced, self._bounces(haar.forward(g), self._bounces.of_lights))

        # Final gather, and direct light on view samples.
        with clock("final_gather"):
            tiles, n = self._tiles[scale], len(view.points(scale))
            arriving = multiply(*self.final, bounced.total, tiles, n)
            # Without glossy pixels nothing takes this up: no need to make zeros of it.
            mirrored = (
                multiply(*self.gloss, bounced.total, tiles, n) if self._reflects else arriving
            )
        if environment is not None:
            with clock("environment_view"):
                matt, gloss = self._environment.view(scale, n)
                arriving += matt
                if self._reflects:
                    mirrored += gloss
        with clock("view_direct"):
            image = view.direct(lights, scale, environment, suns)
        with clock("compose"):
            self._compose(arriving, mirrored, image, scale)
        missing = bounced.unsure / max(bounced.power, 1e-30)
        return Drawn(image, missing, bounced.later, lambda: g, self._first_of, clock.timings())

    def _parts(self) -> Parts:
        return Parts(
            self.view, self.cloud, self._bounces, self.bounce, self.final, self.gloss,
            self._reflects, self._tiles, self._reflectance, self._sub,
        )  # fmt: skip

    def _on_cloud(self, lights: tuple[Light, ...]) -> NDArray[np.float32]:
        """Radiance (n_g, 3) that lights make the gather samples reflect."""
        return self.view.pictures.total("gather", lights, self._light_on_cloud, len(self.cloud))

    def _first_of(self, light: Light) -> NDArray[np.float32]:
        return self._on_cloud((light,))

    def _light_on_cloud(self, light: Light) -> NDArray[np.float32]:
        return light_on_points(self.view.scene.rays, self.cloud.points, light)

    def indirect(self, edits: Edits) -> NDArray[np.float32]:
        """The indirect part of the full picture alone, (height, width, 3): for tests and charts."""
        frame, light = self.relight(edits), self._environment
        lights, environment = self._edited(edits)
        direct = self.view.direct(lights, 1, environment, light.suns if environment else ())
        if environment is not None:
            self._compose(*light.view(1, len(direct)), direct, 1)
        return frame.image - direct.reshape(frame.image.shape)

    def _edited(self, edits: Edits) -> tuple[tuple[Light, ...], Environment | None]:
        scene = self.view.scene
        return (
            edited_lights(scene.lights, edits.lights, scene.folder),
            edited_environment(scene.environment, edits.environment, Path(scene.folder)),
        )

    def _compose(
        self,
        arriving: NDArray[np.float32],
        mirrored: NDArray[np.float32],
        image: NDArray[np.float32],
        scale: int,
    ) -> None:
        """Add the indirect light to the direct, in place."""
        add_indirect(arriving, mirrored, self._reflectance[scale], image)
        if scale == 1:
            add_at_edges(self.view.buffer, arriving, mirrored, self._sub, image)

    def _warnings(
        self,
        lights: tuple[Light, ...],
        environment: Environment | None,
        drawn: Drawn,
        scale: int,
    ) -> tuple[Diagnosis, ...]:
        balance = self._balance(lights, drawn.first_of, drawn.later)

        def first() -> NDArray[np.float32]:
            standing = self._environment.gather if environment is not None else np.float32(0)
            return drawn.first() + self.cloud.emission + standing

        covered = said_of(self._uncovered, self.cloud, drawn.later)
        truncated = self._bounces.truncated(drawn.missing)
        points = self._lamps(lights, drawn.image, scale)
        caustics = self._caustics(first, drawn.later)
        said = (*self._of_view, points, covered, caustics, balance, truncated)
        found = [warning for warning in said if warning is not None]
        if environment is not None:
            found += self._environment.warnings(self._settings.view_rays)
        return tuple(found)
