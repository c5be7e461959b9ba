"""The referee: a path tracer and brute-force direct light, both with their variances."""

from engine.reference.direct import render_direct
from engine.reference.path_tracer import render
from engine.reference.result import Reference

__all__ = ["Reference", "render", "render_direct"]
