"""The one GL context of the process.

A context belongs to the thread that made it, and a process that was forked must not touch its
parent's. So it is made when it is first needed, in the thread that needs it, and never twice.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.source import VERSION, load
from engine.brdf import library
from engine.errors import BackendError

EGL: Any = {"backend": "egl"}  # a context without a display
GROUP = 64  # threads of a work group, in every shader
MOST_GROUPS = 65535  # of a dispatch, by the specification
LIBRARY = "b_library"  # the one block that every program finds for itself
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "basic render")
INSTALL = "on Debian and Ubuntu: apt-get install libegl1 libgl1 libgl1-mesa-dri"


class Device:
    """The context, what it runs on, and the programs that were compiled for it.

    renderer  its name, as the driver gives it
    software  whether it is a software rasteriser
    """

    def __init__(self, context: Any) -> None:
        self.context = context
        # Buffers are let go by any thread, and freed by this one.
        context.gc_mode = "context_gc"
        self.renderer = str(context.info["GL_RENDERER"])
        self.software = any(name in self.renderer.lower() for name in SOFTWARE)
        self._owner = threading.get_ident(), os.getpid()
        self._programs: dict[tuple[Any, ...], Program] = {}
        self._library: tuple[int, Any] = (-1, None)

    def require_own_thread(self) -> None:
        """Raise BackendError elsewhere than where it was made."""
        if (threading.get_ident(), os.getpid()) != self._owner:
            raise BackendError("the GL context belongs to another thread or process")

    def program(
        self,
        name: str,
        defines: Mapping[str, int] | None = None,
        made: Mapping[str, str] | None = None,
    ) -> Program:
        """The compute shader `name`; see `source.load`. Compiled at its first use."""
        key = (name, *(defines or {}).items(), *(made or {}).items())
        if key not in self._programs:
            self._programs[key] = Program(self, name, defines, made)
        return self._programs[key]

    def drawing(self, name: str) -> Any:
        """A program that draws: the shader `name` holds both stages, of which VERTEX is the first.

        Raises BackendError, with the compiler's log, where it does not compile.
        """
        vertex, fragment = (load(name, {stage: 1}) for stage in ("VERTEX", "FRAGMENT"))
        try:
            return self.context.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
        except moderngl.Error as error:
            # Lines are the same in both.
            raise BackendError(f"{name} does not compile:\n{vertex.explain(str(error))}") from None

    def upload(self, array: NDArray[Any]) -> Any:
        """A buffer with the bytes of an array; one of no bytes has room for a few all the same."""
        limit = self.context.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]
        if array.nbytes > limit:
            raise BackendError(f"{array.nbytes} bytes do not fit a buffer of GL ({limit} at most)")
        if array.nbytes == 0:
            return self.room(0)
        return self.context.buffer(np.ascontiguousarray(array))

    def room(self, size: int) -> Any:
        """A buffer of so many bytes, with whatever lies there."""
        return self.context.buffer(reserve=max(16, size))

    def write(self, buffer: Any, data: Any) -> None:
        """Write into a buffer from its beginning, once shaders are done with it.

        By itself a driver may write before the shaders that ran last, whatever barriers say: a list
        that was to be emptied then went on where it had ended.
        """
        self.context.finish()
        buffer.write(data)

    def floats(self, count: int) -> Any:
        """A buffer of zeros for so many float32."""
        buffer = self.room(4 * count)
        buffer.clear()
        return buffer

    def library(self) -> Any:
        """The buffer of all blocks that are filed in `engine.brdf.library`, sent as it grows."""
        count = library.count()
        if self._library[0] != count:
            self._library = count, self.upload(library.packed())
        return self._library[1]

    def check(self) -> None:
        """Raise BackendError if anything went wrong since the last call."""
        error = self.context.error
        if error != "GL_NO_ERROR":
            raise BackendError(f"GL reports {error} on {self.renderer}")


class Program:
    """A compute shader."""

    def __init__(
        self,
        device: Device,
        name: str,
        defines: Mapping[str, int] | None,
        made: Mapping[str, str] | None,
    ) -> None:
        """Raises BackendError, with the compiler's log, where it does not compile."""
        source = load(name, defines, made)
        try:
            self._shader = device.context.compute_shader(source.text)
        except moderngl.Error as error:
            raise BackendError(f"{name} does not compile:\n{source.explain(str(error))}") from None
        self._device = device
        self._blocks = [
            member
            for member in self._shader
            if isinstance(self._shader[member], moderngl.StorageBlock)
        ]
        for binding, block in enumerate(self._blocks):
            self._shader[block].binding = binding

    def run(self, items: int, buffers: Mapping[str, Any], **uniforms: Any) -> None:
        """One thread per item, or fewer that take several each; then everything is visible to all.

        `buffers` by the names of their blocks; what the shader does not use is passed over.
        """
        self.run_groups(min(-(-items // GROUP), MOST_GROUPS), buffers, **uniforms)

    def run_groups(self, groups: int, buffers: Mapping[str, Any], **uniforms: Any) -> None:
        """So many work groups."""
        if groups <= 0:
            return
        for binding, block in enumerate(self._blocks):
            buffer = self._device.library() if block == LIBRARY else buffers[block]
            buffer.bind_to_storage_buffer(binding)
        for name, value in uniforms.items():
            member = self._shader.get(name, None)
            if member is not None:
                member.value = value
        self._shader.run(groups)
        self._device.context.memory_barrier()


class Uploads:
    """Buffers of arrays that seldom change: one is sent again where it is another object."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._sent: dict[str, tuple[NDArray[Any], Any]] = {}

    def of(
        self,
        name: str,
        array: NDArray[Any],
        made: Callable[[NDArray[Any]], NDArray[Any]] = lambda array: array,
    ) -> Any:
        """The buffer of what is made of an array, the last of its name or a new one."""
        if name not in self._sent or self._sent[name][0] is not array:
            self._sent[name] = array, self._device.upload(made(array))
        return self._sent[name][1]


_lock = threading.Lock()
_device: Device | None = None
_failure = ""


def device() -> Device:
    """The device of this process, made by the first caller in its thread.

    Raises BackendError where there is none, and in every other thread.
    """
    global _device, _failure
    with _lock:
        if _failure:
            raise BackendError(_failure)
        if _device is None:
            try:
                context = moderngl.create_context(VERSION, standalone=True, **EGL)
            except Exception as error:  # moderngl raises whatever its loader raises
                _failure = f"GL cannot be started ({error}); {INSTALL}"
                raise BackendError(_failure) from None
            _device = Device(context)
        _device.require_own_thread()
        return _device


@contextmanager
def gl_errors() -> Iterator[None]:
    """Raise BackendError for whatever moderngl raises, such as memory that is used up."""
    try:
        yield
    except moderngl.Error as error:
        raise BackendError(str(error)) from None
