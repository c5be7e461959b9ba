"""The referee: brute-force direct light and a path tracer, both with variances."""

from engine.reference.path_tracer import render
from engine.reference.result import Reference

__all__ = ["Reference", "render"]
