"""Keep compiled kernels of one version of the sources apart from those of the next.

Numba's cache notices a change in a kernel's own file but not in the files of the functions it
calls, so a changed BRDF would go on running its old code. The cache folder is therefore named
after a digest of every source file of the engine.
"""

from __future__ import annotations

import hashlib
import os
from functools import cache
from pathlib import Path

import numba
import platformdirs


@cache
def source_digest() -> str:
    """Hex digest of every source file of the engine."""
    digest = hashlib.blake2b(digest_size=8)
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def use_source_keyed_cache() -> None:
    """Point Numba's cache at a per-user folder named after the engine's sources."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return
    folder = Path(platformdirs.user_cache_dir("relight")) / "kernels" / source_digest()
    numba.config.CACHE_DIR = str(folder)
