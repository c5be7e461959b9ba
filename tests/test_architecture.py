"""The order of imports, the rooms of third-party packages, the size of files, the public lists."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.resources import resource

ROOT = Path(__file__).resolve().parents[1]

# A room may import the rooms of earlier rows, and itself. Rooms of one row do not know each other.
ORDER: list[set[str]] = [
    {"engine.errors", "engine._cache"},
    {"engine.diagnosis", "engine.resources"},
    {"engine.numerics"},
    {"engine.images"},
    {"engine.brdf", "engine.light"},
    {"engine.scene"},
    {"engine.store", "engine.backend"},
    {"engine.methods.base"},
    {"engine.reference", "engine.methods"},
    {"engine.measure"},
    {"engine.terminal", "engine.doctor"},
    {"engine.arguments", "engine.options"},
    {"engine.charts"},
    {"engine.cli_measure"},
    {"engine.cli", "server"},
]

# Third-party packages and the only files or folders that may import them.
ROOMS: dict[str, tuple[str, ...]] = {
    "colour": ("engine/brdf/acquisition/spectrum.py",),
    "embreex": ("engine/scene/rays.py",),
    "trimesh": ("engine/scene/",),
    "moderngl": ("engine/backend/gl/",),
    "glcontext": ("engine/backend/gl/",),
    "fastapi": ("server/",),
    "starlette": ("server/",),
    "uvicorn": ("server/",),
    "websockets": ("server/",),
    "httpx": ("server/client.py",),
    "xxhash": ("engine/store/",),
    "matplotlib": ("engine/measure/",),
    "skimage": ("engine/measure/",),
    "flip_evaluator": ("engine/measure/",),
    "typer": ("engine/cli.py", "engine/cli_measure.py", "engine/options.py"),
    "rich": ("engine/cli.py", "engine/terminal.py", "engine/measure/bench_tables.py"),
    "mitsuba": ("engine/measure/",),
    "mitsuba_oidn": ("engine/measure/",),
    "dask": ("engine/methods/cluster.py",),
    "distributed": ("engine/methods/cluster.py",),
    "fsspec": ("engine/store/remote.py",),
    "playwright": (),
}

# Packages of the extras `chart`, `client`, `cluster` and `peers`.
EXTRAS = {
    "dask",
    "distributed",
    "flip_evaluator",
    "fsspec",
    "httpx",
    "matplotlib",
    "mitsuba",
    "mitsuba_oidn",
    "skimage",
}

# Imports that go against the order when a command is run, never when a module is loaded.
LATE = {("engine.cli", "server"), ("engine.cli_measure", "server")}

LINES = 300
LONG: dict[str, str] = {}  # file -> why it is one idea in spite of its length


def sources() -> list[Path]:
    return sorted(p for room in ("engine", "server") for p in (ROOT / room).rglob("*.py"))


def imports(tree: ast.AST) -> Iterator[str]:
    """Dotted names of the modules that a file imports, wherever in the file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            assert node.module is not None
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def room_of(module: str) -> str | None:
    """The room of a dotted name; `engine` itself is only its public list and above everything."""
    parts = module.split(".")
    if parts[0] == "server":
        return "server"
    if parts[:3] == ["engine", "methods", "base"]:
        return "engine.methods.base"  # the contract stands below those who keep it
    return ".".join(parts[:2]) if parts[0] == "engine" and len(parts) > 1 else None


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def tier(room: str) -> int:
    return next(k for k, rooms in enumerate(ORDER) if room in rooms)


def is_wrong(source: str, target: str) -> bool:
    return source != target and tier(target) >= tier(source) and (source, target) not in LATE


def test_the_order_itself_can_be_broken() -> None:
    assert is_wrong("engine.scene", "engine.methods")
    assert is_wrong("engine.brdf", "engine.light")
    assert is_wrong("engine.methods", "server")
    assert not is_wrong("engine.methods", "engine.scene")
    assert not is_wrong("engine.scene", "engine.scene")


@pytest.mark.parametrize("path", sources(), ids=module_of)
def test_imports_go_one_way(path: Path) -> None:
    room = room_of(module_of(path))
    if room is None:
        return
    wrong = [
        name
        for name in imports(ast.parse(path.read_text()))
        if (target := room_of(name)) is not None and is_wrong(room, target)
    ]
    assert wrong == [], f"{room} must not import {wrong}"


def test_late_imports_are_late() -> None:
    for source, target in LATE:
        tree = ast.parse((ROOT / (source.replace(".", "/") + ".py")).read_text())
        top = ast.Module(
            [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)], []
        )
        assert not any(name.split(".")[0] == target for name in imports(top))


def test_the_service_needs_no_extra() -> None:
    """`make serve` installs none: all that the service loads when it starts loads without."""
    files = {module_of(path): path for path in sources()}
    todo, loaded, extras = [name for name in files if room_of(name) == "server"], set[str](), set()
    todo.remove("server.client")  # for who asks a service
    while todo:
        name = todo.pop()
        if name in loaded:
            continue
        loaded.add(name)
        body = ast.parse(files[name].read_text()).body
        top = ast.Module([n for n in body if isinstance(n, ast.Import | ast.ImportFrom)], [])
        for imported in imports(top):
            extras |= {imported.split(".")[0]} & EXTRAS
            todo += {imported, imported.rpartition(".")[0]} & files.keys()
    assert "engine.measure.metrics" in loaded
    assert extras == set()


@pytest.mark.parametrize("path", sources(), ids=module_of)
def test_third_party_packages_stay_in_their_rooms(path: Path) -> None:
    place = path.relative_to(ROOT).as_posix()
    for name in imports(ast.parse(path.read_text())):
        rooms = ROOMS.get(name.split(".")[0])
        assert rooms is None or place.startswith(rooms), f"{place} must not import {name}"


def test_every_room_of_a_third_party_package_exists() -> None:
    for name, rooms in ROOMS.items():
        assert all((ROOT / room).exists() for room in rooms), name


def test_files_are_short() -> None:
    files = [p for room in ("engine", "server", "web", "shaders") for p in (ROOT / room).rglob("*")]
    code = [p for p in files if p.suffix in {".py", ".js", ".glsl", ".css", ".html"}]
    lines = {p.relative_to(ROOT).as_posix(): len(p.read_text().splitlines()) for p in code}
    long = {name for name, count in lines.items() if count > LINES}
    assert long == set(LONG), "split the file, or say in LONG why it is one idea"


def packages() -> list[str]:
    return sorted({module_of(p) for p in sources() if p.name == "__init__.py"})


@pytest.mark.parametrize("name", packages())
def test_public_lists_name_what_is_there(name: str) -> None:
    package = importlib.import_module(name)
    public = set(getattr(package, "__all__", ()))
    assert {n for n in public if not hasattr(package, n)} == set()
    body = ast.parse(Path(str(package.__file__)).read_text()).body
    if public and sum(not isinstance(node, ast.ImportFrom | ast.Expr) for node in body) == 1:
        imported = {
            alias.asname or alias.name
            for node in body
            if isinstance(node, ast.ImportFrom) and node.module != "__future__"
            for alias in node.names
        }
        assert imported <= public, "a package that only re-exports lists all that it imports"


def test_no_star_imports() -> None:
    for path in sources():
        assert not any(name.endswith(".*") for name in imports(ast.parse(path.read_text()))), path


def test_resources_of_the_checkout() -> None:
    assert resource("shaders") == ROOT / "shaders"
    assert resource("web") == ROOT / "web"


def test_the_wheel_carries_page_and_shaders(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("relight-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    find = "from engine.resources import resource; print(resource('web'), resource('shaders'))"
    run = subprocess.run(
        [sys.executable, "-c", find],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path / "site"), "HOME": str(tmp_path)},
        check=True,
        capture_output=True,
        text=True,
    )
    for name, folder in zip(("web", "shaders"), run.stdout.split(), strict=True):
        assert folder == str(tmp_path / "site" / "engine" / "_shipped" / name)
        there = {p.relative_to(folder).as_posix() for p in Path(folder).rglob("*") if p.is_file()}
        here = ROOT / name
        assert there == {p.relative_to(here).as_posix() for p in here.rglob("*") if p.is_file()}
        assert there
