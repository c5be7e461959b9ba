"""Field types shared by everything that is read from JSON: finite, bounded, strict."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Description(BaseModel):
    """A frozen piece of a scene description: unknown keys, NaN and infinity are refused."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


Finite = Annotated[float, Field(ge=-1e9, le=1e9)]
Point = tuple[Finite, Finite, Finite]
Unit = Annotated[float, Field(ge=0, le=1)]
NonNegative = Annotated[float, Field(ge=0, le=1e12)]
Reflectance = tuple[Unit, Unit, Unit]
Radiance = tuple[NonNegative, NonNegative, NonNegative]
