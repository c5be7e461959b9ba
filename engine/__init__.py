"""Relight's engine: precompute how light moves through a scene, then relight it at once."""

from engine._cache import use_source_keyed_cache

use_source_keyed_cache()
