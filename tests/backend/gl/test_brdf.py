"""Every BRDF in GLSL equals its Python twin."""

from __future__ import annotations

import numpy as np
import pytest
from backend.gl.one_call import call
from brdf.materials import EXTREMES, LOBES, hemisphere, name_of

from engine import brdf
from engine.backend.gl.context import Device
from engine.backend.gl.tables import BRDF_TABLE, brdf_table
from engine.brdf import Material
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.table import INDEX

pytestmark = pytest.mark.gl
COUNT = 2000


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """Directions at random, about each other's mirror image, and below the surface."""
    rng = np.random.default_rng(2)
    wi, wo = hemisphere(rng, COUNT), hemisphere(rng, COUNT)
    near = slice(0, COUNT // 2)
    wi[near] = wo[near] * (-1, -1, 1) + rng.normal(size=(COUNT // 2, 3)) * 10 ** rng.uniform(
        -4, -0.5, (COUNT // 2, 1)
    )
    wi[-100:, 2] *= -1
    wo[-50:, 2] *= -1
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    return wi.astype(np.float32), wo.astype(np.float32)


def twins(
    gpu: Device, material: Material, wi: np.ndarray, wo: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What the shader and what Python makes of directions (COUNT, 3) float32."""
    model, row = INDEX[type(material)], material.row()
    found = call(
        gpu, BRDF_TABLE, "f.x, f.y, f.z", 3, made={BRDF_TABLE: brdf_table()},
        before="vec3 f = evaluate(int(model), p, wi, wo);",
        model=np.array([[model]]), p=row[None], wi=wi, wo=wo,
    )  # fmt: skip
    # What float32 rounds off the length of a direction is no difference between the twins.
    exact = [
        w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi.astype(float), wo.astype(float))
    ]
    models, rows = np.full(COUNT, model, np.int32), np.repeat(row[None], COUNT, axis=0)
    expected = brdf.evaluate(models, rows, *exact)
    assert np.isfinite(found).all()
    return found, expected


@pytest.mark.parametrize("material", LOBES + EXTREMES, ids=name_of)
def test_evaluate(gpu: Device, material: Material):
    found, expected = twins(gpu, material, *pairs())
    peak = np.abs(expected).max()
    assert np.linalg.norm(found - expected) <= 1e-4 * np.linalg.norm(expected)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-6 * peak)


@pytest.mark.parametrize("roughness", [0.1, 0.3, 1.0])
def test_cook_torrance_has_digits_at_grazing_angles(gpu: Device, roughness: float):
    """Cosines from 1e-6, about the plane of the mirror: where wi + wo is short."""
    rng = np.random.default_rng(3)
    z = 10 ** rng.uniform(-6, -1, (2, COUNT))
    phi = np.stack(
        [np.zeros(COUNT), np.pi + rng.normal(size=COUNT) * 10 ** rng.uniform(-4, 0, COUNT)]
    )
    r = np.sqrt(1 - z * z)
    wi, wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=2).astype(np.float32)
    material = CookTorrance(diffuse=(0, 0, 0), specular=(0.5,) * 3, roughness=roughness)
    found, expected = twins(gpu, material, wi, wo)
    assert (expected.max(axis=1) > 1).sum() > 100
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6)
