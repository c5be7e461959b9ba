"""Measured reflectance: from files to values for any pair of directions.

    file -> samples (`goniometer`, `csv_table`) -> function (`completion`) -> report
    file -> table (`merl`) -> report

Local directions: z is the normal, both leave the surface; BRDF in sr⁻¹ without the cosine, linear
sRGB. After Claustres, Barthe and Paulin 2007, Wavelet Encoding of BRDFs for Real-Time Rendering,
§3 and figure 4, whose first stages these are.
"""

from engine.brdf.acquisition.analytic import of_material
from engine.brdf.acquisition.files import read
from engine.brdf.acquisition.measurement import Measurement
from engine.brdf.acquisition.report import Report

__all__ = ["Measurement", "Report", "of_material", "read"]
