"""Which backend draws, and what is said where it is another than the one that was asked for."""

from __future__ import annotations

import threading

import pytest

from engine.backend import choice
from engine.backend.choice import VARIABLE, chosen_device, wanted
from engine.backend.gl import context
from engine.backend.gl.context import device
from engine.errors import BackendError, InputError


def test_the_argument_goes_before_the_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert wanted() == "auto"
    monkeypatch.setenv(VARIABLE, "gl")
    assert wanted() == "gl"
    assert wanted("cpu") == "cpu"


def test_a_name_that_is_no_backend(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"backend: 'vulkan' .* auto, cpu, gl"):
        wanted("vulkan")
    monkeypatch.setenv(VARIABLE, "metal")
    with pytest.raises(InputError, match=VARIABLE):
        wanted()


def missing() -> None:
    raise BackendError("GL cannot be started (no libEGL.so); install it")


def test_missing_gl(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only who asked for it is told."""
    monkeypatch.setattr(choice, "device", missing)
    found, notices = chosen_device("gl")
    assert found is None
    assert [notice.code for notice in notices] == ["gl_unavailable"]
    assert "CPU" in notices[0].message
    assert "no libEGL.so" in notices[0].message
    assert chosen_device("auto") == (None, ())
    assert chosen_device("cpu") == (None, ())


@pytest.mark.gl
def test_auto_wants_hardware(monkeypatch: pytest.MonkeyPatch) -> None:
    found = device()
    for software, chosen in ((True, None), (False, found)):
        monkeypatch.setattr(found, "software", software)
        assert chosen_device("auto") == (chosen, ())
        assert chosen_device("gl") == (found, ())


@pytest.mark.gl
@pytest.mark.parametrize(
    ("renderer", "software"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("Google SwiftShader", True),
        ("Microsoft Basic Render Driver", True),
        ("NVIDIA H100/PCIe/SSE2", False),
        ("AMD Radeon RX 6800 (radeonsi, navi21, LLVM 15.0.6)", False),
        ("Mesa Intel(R) UHD Graphics 620 (KBL GT2)", False),
    ],
)
def test_renderers(renderer: str, software: bool) -> None:
    class Fake:
        gc_mode = None
        info = {"GL_RENDERER": renderer}  # noqa: RUF012

    assert context.Device(Fake()).software == software


@pytest.mark.gl
def test_one_device_and_one_thread() -> None:
    mine = device()
    assert device() is mine
    found: list[object] = []

    def elsewhere() -> None:
        try:
            device()
        except BackendError as error:
            found.append(error)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert "another thread" in str(found[0])


@pytest.mark.gl
def test_not_after_a_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    device()
    monkeypatch.setattr(context.os, "getpid", lambda: -1)
    with pytest.raises(BackendError, match="process"):
        device()


@pytest.mark.gl
def test_an_error_of_gl_is_raised() -> None:
    gpu = device()
    gpu.check()
    gpu.room(16).bind_to_storage_buffer(10**6)  # there is no such binding anywhere
    with pytest.raises(BackendError, match="GL_INVALID_VALUE"):
        gpu.check()
    gpu.check()
    too_long = gpu.context.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] + 1

    class Long:
        nbytes = too_long

    with pytest.raises(BackendError, match=str(too_long)):
        gpu.upload(Long())  # type: ignore[arg-type]
