"""Precompute is deterministic, can be stopped anywhere, and mends what it finds broken."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import subprocess
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from methods.scenes import POINT, cornell, white_room, with_camera

from engine.errors import Cancelled
from engine.methods import prepare
from engine.methods.direct_to_indirect import Settings, Transfer
from engine.methods.direct_to_indirect.precompute import NEEDS, key
from engine.numerics.parallel import mark_worker
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

# A chunk is 64 tiles of 64: 1024 samples make one, 96 x 96 pixels three.
SETTINGS = Settings(
    gather_samples=1024, coefficients=16, bounce_coefficients=16, view_rays=64, bounce_rays=64
)
SIZE = 96
ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def box() -> Scene:
    """Under its spot alone, which is quick to light with."""
    return box_under_spot()


def box_under_spot() -> Scene:
    box = cornell(SIZE)
    return box.with_lights(box.lights[1:])


def made(scene: Scene, folder: Path, **more: Any) -> Transfer:
    return prepare(  # type: ignore[return-value]
        scene, "direct_to_indirect", SETTINGS, store=Store(folder), **more
    )


def digest(product: Transfer) -> str:
    rows = [*product.final, *product.gloss, *product.bounce]
    arrays = [*rows, product.cloud.points.position, product.cloud.albedo]
    joined = b"".join(a.tobytes() for a in arrays) + product.relight(Edits()).image.tobytes()
    return hashlib.blake2b(joined, digest_size=16).hexdigest()


@pytest.fixture(scope="module")
def expected(box: Scene, tmp_path_factory: pytest.TempPathFactory) -> str:
    return digest(made(box, tmp_path_factory.mktemp("expected")))


class Counting(Executor):
    """Runs everything at once, in order, and counts."""

    def __init__(self) -> None:
        self.chunks = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future:
        self.chunks += 1
        future: Future = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def test_same_bytes_twice_and_from_another_executor(
    box: Scene, tmp_path: Path, expected: str
) -> None:
    assert digest(made(box, tmp_path / "a")) == expected
    one_by_one = Counting()
    assert digest(made(box, tmp_path / "b", executor=one_by_one)) == expected
    assert one_by_one.chunks == 4


def test_another_seed_gives_other_bytes(box: Scene, tmp_path: Path, expected: str) -> None:
    other = Settings(gather_samples=1024, coefficients=16, bounce_coefficients=16, seed=2)
    assert digest(prepare(box, "direct_to_indirect", other, store=Store(tmp_path))) != expected  # type: ignore[arg-type]


SCRIPT = """
import sys
from pathlib import Path
sys.path.insert(0, "tests")
from engine.methods import prepare
from methods.direct_to_indirect import test_precompute as t
print(t.digest(t.made(t.box_under_spot(), Path(sys.argv[1]))))
"""


@pytest.mark.parametrize("threads", ["1", "2"])
def test_same_bytes_whatever_the_threads(tmp_path: Path, expected: str, threads: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "RELIGHT_THREADS": threads, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-1] == expected


@pytest.mark.sweep
def test_same_bytes_from_a_pool_of_processes(box: Scene, tmp_path: Path, expected: str) -> None:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, context, mark_worker) as pool:
        assert digest(made(box, tmp_path, executor=pool)) == expected


@pytest.mark.parametrize("stop_at", ["bounce", "final"])
def test_an_interrupted_precompute_resumes(
    box: Scene, tmp_path: Path, expected: str, stop_at: str
) -> None:
    """Nothing that was finished is done again, and the bytes are the same."""

    def stop(phase: str, done: float, total: float) -> None:
        if phase == stop_at and done >= 1:
            raise Cancelled("enough")

    first, second = Counting(), Counting()
    with pytest.raises(Cancelled):
        made(box, tmp_path, executor=first, progress=stop)
    assert digest(made(box, tmp_path, executor=second)) == expected
    # In order the executor finishes all that it is given: one of bounce, then three of final.
    assert first.chunks == (1 if stop_at == "bounce" else 4)
    assert first.chunks + second.chunks == 4
    for name in NEEDS:
        assert not Store(tmp_path).entry(key(box, SETTINGS, name) + ".parts").folder.exists()


def test_a_lost_chunk_is_made_again(box: Scene, tmp_path: Path, expected: str) -> None:
    """Of an interrupted precompute whose files were damaged only the damaged ones are redone."""

    def stop(phase: str, done: float, total: float) -> None:
        if phase == "final" and done == total:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        made(box, tmp_path, executor=Counting(), progress=stop)
    parts = Store(tmp_path).entry(key(box, SETTINGS, "final") + ".parts")
    assert {"final-0", "final-1", "final-2"} <= set(parts.names())
    damage(parts.folder / "final-1.relight")
    again = Counting()
    assert digest(made(box, tmp_path, executor=again)) == expected
    assert again.chunks == 1


def damage(path: Path) -> None:
    """Flip bits in the middle of a file, and leave its length."""
    data = bytearray(path.read_bytes())
    for k in range(len(data) // 2, len(data) // 2 + 256):
        data[k] ^= 0xFF
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("name", "chunks", "how"),
    [
        ("cloud", 0, "damaged"),
        ("bounce", 1, "damaged"),
        ("final", 3, "damaged"),
        ("final", 3, "cut"),
        ("final", 3, "removed"),
    ],
)
def test_a_broken_file_is_built_again(
    box: Scene, tmp_path: Path, expected: str, name: str, chunks: int, how: str
) -> None:
    made(box, tmp_path)
    path = Store(tmp_path).entry(key(box, SETTINGS, name)).folder / f"{name}.relight"
    if how == "damaged":
        damage(path)
    elif how == "cut":
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    else:
        path.unlink()
    again = Counting()
    assert digest(made(box, tmp_path, executor=again)) == expected
    assert again.chunks == chunks
    untouched = Counting()
    assert digest(made(box, tmp_path, executor=untouched)) == expected
    assert untouched.chunks == 0


def test_an_error_in_a_chunk_is_raised(box: Scene, tmp_path: Path) -> None:
    class Failing(Executor):
        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future:
            future: Future = Future()
            future.set_exception(MemoryError("no room"))
            return future

    with pytest.raises(MemoryError, match="no room"):
        made(box, tmp_path, executor=Failing())


def test_progress_runs_forward_through_named_phases(tmp_path: Path) -> None:
    said: list[tuple[str, float, float]] = []
    made(
        white_room(0.5, [POINT], 16),
        tmp_path,
        progress=lambda phase, done, total: said.append((phase, done, total)),
    )
    phases = list(dict.fromkeys(phase for phase, _, _ in said))
    assert phases == ["view samples", "gather cloud", "importance", "bounce", "final"]
    for phase in phases:
        steps = [done for name, done, _ in said if name == phase]
        total = next(total for name, _, total in said if name == phase)
        assert steps == sorted(steps)
        assert steps[0] == 0
        assert steps[-1] == total


def test_the_key_knows_what_matters() -> None:
    """Geometry, materials, camera and settings; neither lights nor bounces."""

    def keys(scene: Scene, settings: Settings) -> tuple[str, ...]:
        return tuple(key(scene, settings, part) for part in NEEDS)

    room = white_room(0.5, [POINT], 8)
    plain = keys(room, SETTINGS)
    assert plain == keys(white_room(0.5, [], 8), SETTINGS)
    assert plain == keys(room, Settings(**{**SETTINGS.__dict__, "bounces": 7}))
    others = [
        keys(white_room(0.6, [POINT], 8), SETTINGS),
        keys(with_camera(room, fov_y_degrees=20), SETTINGS),
        keys(with_camera(room, width=9), SETTINGS),
        *(
            keys(room, Settings(**{**SETTINGS.__dict__, field: value}))
            for field, value in (
                ("gather_samples", 256),
                ("coefficients", 17),
                ("bounce_coefficients", 17),
                ("position_weight", 7.0),
                ("gloss_coefficients", 17),
                ("gather", "links"),
                ("cloud", "importance"),
                ("view_rays", 99),
                ("gloss_rays", 99),
                ("bounce_rays", 99),
                ("link_size", 0.06),
                ("bounce_link_size", 0.11),
                ("patch_size", 0.4),
                ("seed", 2),
            )
        ),
    ]
    assert len({plain, *others}) == 1 + len(others)
