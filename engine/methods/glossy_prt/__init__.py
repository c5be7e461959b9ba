"""`glossy_prt`: Wang, Tran, Luebke 2006, *All-Frequency Relighting of Glossy Objects*.

The geometry and the materials stand still; the camera and the environment move.
"""

from __future__ import annotations

from engine.methods.base import EDITS, Method
from engine.methods.glossy_prt.precompute import precompute
from engine.methods.glossy_prt.product import NAME, Prt
from engine.methods.glossy_prt.settings import Settings

METHOD = Method(
    name=NAME,
    paper="Wang, Tran, Luebke 2006, All-Frequency Relighting of Glossy Objects",
    edits=EDITS[NAME],
    settings=Settings,
    precompute=precompute,
)

__all__ = ["METHOD", "Prt", "Settings"]
