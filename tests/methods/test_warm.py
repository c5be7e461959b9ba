"""After the kernels have been compiled once, a session compiles none."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numba
import pytest

from engine.brdf.table import MODELS
from engine.light.table import LIGHTS
from engine.methods import warm

# A session in a process of its own: every call that needs a kernel which is not there says so.
SESSION = """
import sys
from pathlib import Path
import numba.core.dispatcher as dispatcher
missed = []
compile = dispatcher._FunctionCompiler.compile
def watched(self, *args):
    missed.append(self.py_func.__qualname__)
    return compile(self, *args)
dispatcher._FunctionCompiler.compile = watched
from engine.methods import prepare, warm
from engine.methods.direct_to_indirect import Settings
from engine.methods.fixed_view.preview import DirectPreview
from engine.numerics.display import to_srgb8
from engine.scene.edits import Edits, edited_camera
from engine.scene.open import open_scene
from engine.store import Store
scene = open_scene(sys.argv[1])
scene = scene.with_camera(edited_camera(scene.camera, {"width": 40, "height": 30}))
store = Store(Path(sys.argv[2]))
lights = [{"id": light.id, "intensity": [1, 2, 3]} for light in scene.lights]
light = {"direction": [1, -1, 0]}
environment = {"map": "studio", "rotation_degrees": 20, "area_light": light}
settings = Settings(gather_samples=256)
products = [prepare(scene, warm.METHOD, settings, store=store) for _ in range(2)]
for view in (DirectPreview(scene), *products):
    for scale in (1, 2):
        edits = Edits(lights=lights, environment=environment)
        to_srgb8(view.relight(edits, scale).image, 0.5)
print(sorted(set(missed)))
"""


@pytest.mark.parametrize("scene", ["cornell-box", "room"])
def test_a_session_compiles_nothing(scene: str, tmp_path: Path) -> None:
    warm.compile_kernels()
    run = subprocess.run(
        [sys.executable, "-c", SESSION, scene, str(tmp_path)],
        capture_output=True,
        text=True,
        check=True,
    )
    # But a constant: where this process keeps its measured materials, see `engine.brdf.library`.
    assert run.stdout.strip() == "['_address']"


def test_the_tiny_scene_has_every_light_and_material() -> None:
    scene = warm.tiny_scene()
    assert {type(light) for light in scene.lights} == set(LIGHTS)
    assert {type(material) for material in scene.materials} == set(MODELS)
    assert scene.environment is not None


def test_the_marker_stops_a_second_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    (tmp_path / warm.MARKER).touch()
    called: list[str] = []
    warm.compile_kernels(lambda phase, done, total: called.append(phase))
    assert called == []
