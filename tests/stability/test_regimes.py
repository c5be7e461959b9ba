"""Every regime in a small picture: what is bound holds, what must be said is said, and no more."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from engine.diagnosis import VOCABULARY
from engine.measure.machine import this_machine
from engine.measure.regimes import BUDGET, GROUPS, REGIMES, Outcome, Regime, run
from engine.measure.stability import counts, markdown, regimes_document, write
from engine.methods import METHODS
from engine.store import Store

SIDE = 32
# What no warning knows of yet.
SILENT = {"sun of four texels that grazes", "small bright patch"}
# Of these `make sweep` alone takes care, for they take long.
SLOW = {
    "glossy and coarse", "small bright patch", "tiny light and closed white room",
    "sun of four texels", "sun of four texels that grazes", "sharp gloss in four terms",
    "occluders of a hundred vertices", "texture of roughness under a sky", "white pit",
    "caustic of brushed metal",
}  # fmt: skip
QUICK = [regime for regime in REGIMES if regime.name not in SLOW]
Measure = Callable[[Regime], Outcome]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Measure:
    """measured(regime): its outcome in a small picture, found once."""
    store, found = Store(tmp_path_factory.mktemp("regimes")), dict[str, Outcome]()

    def outcome(regime: Regime) -> Outcome:
        if regime.name not in found:
            found[regime.name] = run(regime, SIDE, store, small=True)
        return found[regime.name]

    return outcome


@pytest.mark.parametrize(
    "regime",
    [
        pytest.param(
            regime, id=regime.name, marks=[pytest.mark.sweep] if regime.name in SLOW else []
        )
        for regime in REGIMES
    ],
)
def test_a_regime(measured: Measure, regime: Regime) -> None:
    found = measured(regime)
    assert np.isfinite(found.ours).all()
    assert found.ours.min() >= 0
    assert found.error < regime.bound
    assert set(regime.codes) <= set(found.sizes)
    if found.mended is not None:
        assert found.mended < 0.75 * found.error
    if regime in GROUPS["at ease"]:
        assert found.error < BUDGET
        assert found.sizes == {}


@pytest.mark.parametrize("regimes", [QUICK, pytest.param(REGIMES, marks=pytest.mark.sweep)])
def test_warnings_are_seldom_false_and_seldom_lacking(
    measured: Measure, regimes: Sequence[Regime]
) -> None:
    found = counts([measured(regime) for regime in regimes])
    assert found["false_alarms"] == []
    assert found["overstated"] == []
    assert set(found["silent"]) == SILENT & {regime.name for regime in regimes}


def test_all_that_can_be_said_of_a_picture_is_provoked() -> None:
    """By regimes of all methods, two difficulties at once among them."""
    provoked = {code for regime in REGIMES for code in regime.codes}
    assert provoked == {code for code, entry in VOCABULARY.items() if entry.of == "picture"}
    assert {regime.method for regime in REGIMES} == set(METHODS)
    assert {regime.method for regime in GROUPS["at ease"]} == set(METHODS)
    assert {regime.method for regime in GROUPS["together"]} == set(METHODS)
    assert len({regime.name for regime in REGIMES}) == len(REGIMES)


def test_the_document_and_its_pictures(measured: Measure, tmp_path: Path) -> None:
    outcomes = [measured(REGIMES[0]), measured(GROUPS["at ease"][0])]
    document = regimes_document(outcomes, SIDE, this_machine())
    paths = write(outcomes, document, tmp_path)
    assert [path.name for path in paths] == [
        "stability.json", "stability.md", "stability-lights.png", "stability-at-ease.png",
    ]  # fmt: skip
    kept = json.loads((tmp_path / "stability.json").read_text())
    assert [row["name"] for row in kept["regimes"]] == [o.regime.name for o in outcomes]
    assert kept["regimes"][0]["warnings"] == outcomes[0].sizes
    assert "| lamp 1 mm from a wall | `direct_to_indirect` |" in "\n".join(markdown(document))
