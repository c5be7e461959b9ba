"""Schlick's approximation of what an interface reflects (Schlick 1994, eq. 15), for colours.

F = F0 + (F90 - F0)(1 - cos)⁵. F90 is 1 unless F0 stays below 2 %, which no real interface does:
from there F90 falls to 0 with F0 (Lagarde and de Rousiers 2014, §3.2), so that black reflects
nothing.
"""

from __future__ import annotations

from engine.numerics.dispatch import formula


@formula
def f90(f0):
    """Reflectance at grazing incidence of an interface with the colour f0 at normal incidence."""
    return min(1.0, 50.0 * max(f0[0], f0[1], f0[2]))


@formula
def rise(cosine):
    """(1 - cos)⁵: how far F is on its way from F0 to F90."""
    return (1.0 - min(1.0, max(0.0, cosine))) ** 5


@formula
def fresnel(f0, cosine):
    """F for a colour; cosine is that of the angle to the interface's normal."""
    w = rise(cosine)
    g = f90(f0) * w
    return (f0[0] * (1.0 - w) + g, f0[1] * (1.0 - w) + g, f0[2] * (1.0 - w) + g)
