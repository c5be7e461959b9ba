"""BRDFs: one contract (`base`), one file per model, one table.

Everything here takes local directions: z is the normal, both directions leave the surface, and
the value does not include the cosine. The functions below take arrays of any number of materials
and directions; kernels call those of `table`, one direction at a time.
"""

from engine.brdf.albedo import albedo, albedo_diagnosis, hemispherical_albedo
from engine.brdf.arrays import evaluate, pdf, sample
from engine.brdf.base import Material
from engine.brdf.table import AnyMaterial

__all__ = [
    "AnyMaterial",
    "Material",
    "albedo",
    "albedo_diagnosis",
    "evaluate",
    "hemispherical_albedo",
    "pdf",
    "sample",
]
