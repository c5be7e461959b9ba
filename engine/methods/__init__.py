"""The four methods, one package each, and the contract they share (`base`)."""

from __future__ import annotations

from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

from engine.errors import NotFound
from engine.methods import brdf_editing, direct_to_indirect, glossy_prt, wavelet_brdf
from engine.methods.base import EDITS, Frame, Method, Product, Progress, silent
from engine.numerics.parallel import mark_worker, thread_count
from engine.scene.scene import Scene
from engine.store import Store

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (direct_to_indirect, glossy_prt, brdf_editing, wavelet_brdf)
}


def prepare(
    scene: Scene,
    method: str,
    settings: Any = None,
    progress: Progress = silent,
    *,
    store: Store | None = None,
    executor: Executor | None = None,
) -> Product:
    """The product of a method, from the store where it is there, else precomputed into it.

    `settings` None means the paper's; `store` None the user's; `executor` None a pool of threads.
    Raises NotFound for an unknown method and whatever `progress` raises.
    """
    if method not in METHODS:
        raise NotFound(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    chosen = METHODS[method]
    settings = chosen.settings() if settings is None else settings
    store = Store() if store is None else store
    if executor is not None:
        return chosen.precompute(scene, settings, executor, progress, store)
    with ThreadPoolExecutor(thread_count(), "relight-precompute", mark_worker) as threads:
        return chosen.precompute(scene, settings, threads, progress, store)


__all__ = ["EDITS", "METHODS", "Frame", "Method", "Product", "Progress", "prepare", "silent"]
