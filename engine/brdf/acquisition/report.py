"""What a measurement holds, what had to be done to it, and what its user should know."""

from __future__ import annotations

from dataclasses import dataclass

from engine.brdf.albedo import TOLERANCE
from engine.diagnosis import Diagnosis

WITHIN_DEGREES = 10.0  # a pair no farther than this from a sample counts as covered
MUCH_EXTRAPOLATED = 0.1  # of the domain
MUCH_UNLIKE = 0.2  # relative difference of a pair of samples and its reverse
CHANNELS = ("red", "green", "blue")


@dataclass(frozen=True)
class Energy:
    """The largest directional albedo of a BRDF over all outgoing directions and channels.

    albedo         ∫ f cos θ_i dwi
    angle_degrees  of that direction to the normal
    channel        0, 1 or 2
    """

    albedo: float
    angle_degrees: float
    channel: int


@dataclass(frozen=True)
class Report:
    """Figures about one measurement.

    name                 of the material
    isotropic            how it was taken
    samples              number of samples, or of cells of a table, used
    dropped              rows left out because a direction lies below the surface
    clamped              measured values below 0, which became 0
    out_of_gamut         samples with a colour that sRGB cannot mix, whose negative channels became
                         0
    filled               cells of a table above the surface that held no value
    coverage             part of all pairs, weighed by the projected solid angles of both
                         directions, that lie within WITHIN_DEGREES of a sample
    largest_gap_degrees  the farthest that a pair lies from all samples
    reverse_pairs        samples whose reverse was measured too, or nearly so
    unlike_reverses      median relative difference of those, 0 where there are none
    reverse_bias         the same with its sign: positive where steeper light gives more
    unlike_after         the largest such difference of the function itself
    energy_before        of the samples, each standing for the pairs nearest to it
    energy_after         of the function
    """

    name: str
    isotropic: bool
    samples: int
    energy_before: Energy
    energy_after: Energy
    dropped: int = 0
    clamped: int = 0
    out_of_gamut: int = 0
    filled: int = 0
    coverage: float = 1.0
    largest_gap_degrees: float = 0.0
    reverse_pairs: int = 0
    unlike_reverses: float = 0.0
    reverse_bias: float = 0.0
    unlike_after: float = 0.0

    @property
    def extrapolated(self) -> float:
        """The part of all pairs that lies farther than WITHIN_DEGREES from every sample."""
        return 1.0 - self.coverage

    def diagnoses(self) -> list[Diagnosis]:
        """What is wrong with the data and what to do about it, the gravest first."""
        return [
            *self._of_energy(),
            *self._of_coverage(),
            *self._of_reciprocity(),
            *self._of_rows(),
            *self._of_colours(),
        ]

    def _of_energy(self) -> list[Diagnosis]:
        worst = self.energy_after
        if worst.albedo <= 1.0 + TOLERANCE:
            return []
        share = f"{worst.albedo:.2f} times the {CHANNELS[worst.channel]} light it receives"
        return [
            Diagnosis(
                "albedo_above_one",
                f"the measured material {self.name!r} reflects {share}, seen "
                f"{worst.angle_degrees:g} degrees from the normal, and is used as it is; check the "
                "calibration and the samples at grazing angles, or indirect light will be too "
                "bright",
                worst.albedo - 1.0,
            )
        ]

    def _of_coverage(self) -> list[Diagnosis]:
        if self.extrapolated <= MUCH_EXTRAPOLATED:
            return []
        return [
            Diagnosis(
                "measurement_has_gaps",
                f"{self.extrapolated:.0%} of what can be seen of the material {self.name!r} lies "
                f"more than {WITHIN_DEGREES:g} degrees from every sample, some of it "
                f"{self.largest_gap_degrees:.0f} degrees, and is guessed from the nearest ones; "
                "measure more pairs of directions, at grazing angles and out of plane too",
                self.extrapolated,
            )
        ]

    def _of_reciprocity(self) -> list[Diagnosis]:
        bias = abs(self.reverse_bias)
        if bias > MUCH_UNLIKE:
            brighter = "steep" if self.reverse_bias > 0 else "grazing"
            return [
                Diagnosis(
                    "measurement_not_reciprocal",
                    f"samples of the material {self.name!r} under {brighter} light are "
                    f"{bias:.0%} brighter than those with light and eye swapped, and both are "
                    "weighed alike; check whether the values were divided by the cosine of the "
                    "incident angle",
                    bias,
                )
            ]
        if self.unlike_after > MUCH_UNLIKE:
            return [
                Diagnosis(
                    "material_not_reciprocal",
                    f"the material {self.name!r} differs by up to {self.unlike_after:.0%} when "
                    "light and eye are swapped; a method that takes it from either side may show "
                    "either",
                    self.unlike_after,
                )
            ]
        return []

    def _of_rows(self) -> list[Diagnosis]:
        out = []
        if self.dropped:
            rows = "1 row has" if self.dropped == 1 else f"{self.dropped} rows have"
            out.append(
                Diagnosis(
                    "samples_below_surface",
                    f"{rows} a direction below the surface of the material {self.name!r} and "
                    "cannot be used; check that angles are measured from the normal",
                    self.dropped / (self.dropped + self.samples),
                )
            )
        if self.clamped:
            values = "1 value" if self.clamped == 1 else f"{self.clamped} values"
            out.append(
                Diagnosis(
                    "samples_below_zero",
                    f"{values} of the material {self.name!r} below 0 became 0; a few of them are "
                    "noise, many mean that too much dark signal was subtracted",
                    min(1.0, self.clamped / (3 * self.samples)),
                )
            )
        if self.filled:
            cells = "1 cell" if self.filled == 1 else f"{self.filled} cells"
            out.append(
                Diagnosis(
                    "measurement_has_holes",
                    f"{cells} of the table of the material {self.name!r} hold no value and were "
                    "filled from the nearest ones that do",
                    self.filled / (self.filled + self.samples),
                )
            )
        return out

    def _of_colours(self) -> list[Diagnosis]:
        if not self.out_of_gamut:
            return []
        return [
            Diagnosis(
                "colours_out_of_gamut",
                f"{self.out_of_gamut} of {self.samples} samples of the material {self.name!r} are "
                "more saturated than sRGB can show; their negative channels became 0, so that it "
                "looks a little paler and brighter than it is",
                self.out_of_gamut / self.samples,
            )
        ]
