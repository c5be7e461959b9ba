"""The scripts behind `make`: what they install, and what they say where they may not."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / ".ci" / "system-packages"


class Machine:
    """Commands that pretend: what is installed, who runs, whether sudo and apt-get work."""

    def __init__(self, folder: Path) -> None:
        self.bin, self.log = folder / "bin", folder / "log"
        self.bin.mkdir()
        self.log.touch()
        self.command(
            "dpkg-query",
            'grep -qx "${@: -1}" "$(dirname "$0")/installed" && echo "install ok installed"',
        )
        (self.bin / "installed").write_text("make\npython3\n")
        self.command("id", "echo 0")
        self.command("apt-get", f'echo "apt-get $*" >> {self.log}')
        for tool in ("bash", "grep", "dirname", "echo"):
            (self.bin / tool).symlink_to(
                f"/bin/{tool}" if tool != "dirname" else "/usr/bin/dirname"
            )

    def command(self, name: str, body: str) -> None:
        path = self.bin / name
        path.write_text(f"#!/bin/bash\n{body}\n")
        path.chmod(0o755)

    def run(self, *packages: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(self.bin / "bash"), str(SCRIPT), *packages],
            env={"PATH": str(self.bin)},
            capture_output=True,
            text=True,
        )


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_nothing_missing_is_silent(machine: Machine) -> None:
    run = machine.run("make", "python3")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert machine.log.read_text() == ""


def test_root_installs_only_what_is_missing(machine: Machine) -> None:
    run = machine.run("make", "libegl1", "python3", "chromium")
    assert run.returncode == 0, run.stderr
    assert re.fullmatch(r"apt-get install -y .*libegl1 chromium\n", machine.log.read_text())


def test_stale_package_lists_are_renewed(machine: Machine) -> None:
    machine.command("apt-get", f'echo "$1" >> {machine.log}; grep -q update {machine.log}')
    run = machine.run("libegl1")
    assert run.returncode == 0, run.stderr
    assert machine.log.read_text() == "install\nupdate\ninstall\n"


def test_others_go_through_sudo(machine: Machine) -> None:
    machine.command("id", "echo 1000")
    machine.command("sudo", f'echo "sudo" >> {machine.log}; [ "$1" = -n ] && "${{@:2}}"')
    machine.command("true", "")
    run = machine.run("libegl1")
    assert run.returncode == 0, run.stderr
    assert "sudo\napt-get install -y" in machine.log.read_text()


@pytest.mark.parametrize("sudo", ["exit 1", None])
def test_where_it_may_not_it_says_what_to_type(machine: Machine, sudo: str | None) -> None:
    machine.command("id", "echo 1000")
    if sudo:
        machine.command("sudo", sudo)
    run = machine.run("libegl1", "make", "chromium")
    assert run.returncode == 1
    assert run.stderr.splitlines() == [
        "relight needs system packages; please run: sudo apt-get install -y libegl1 chromium"
    ]
    assert machine.log.read_text() == ""


def test_a_failed_installation_says_what_to_type(machine: Machine) -> None:
    machine.command("apt-get", "echo broken >&2; exit 100")
    run = machine.run("libegl1")
    assert run.returncode == 1
    assert run.stderr.splitlines()[-1].endswith("please run: sudo apt-get install -y libegl1")


def test_ci_runs_what_a_contributor_types() -> None:
    run = (ROOT / ".ci" / "run").read_text()
    assert run.startswith("#!/usr/bin/env bash\n")
    assert "set -euo pipefail" in run
    assert re.search(r"make .*\btest\b", run)
    for script in (ROOT / ".ci").iterdir():
        assert os.access(script, os.X_OK), script


def test_make_knows_its_targets() -> None:
    for target in ("serve", "test", "bench", "chart", "clean"):
        subprocess.run(["make", "-n", target], cwd=ROOT, check=True, capture_output=True)
        assert f"# make {target}" in (ROOT / "Makefile").read_text()
