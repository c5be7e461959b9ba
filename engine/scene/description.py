"""A scene as a person writes it: the JSON vocabulary of scenes and edits, and its schema."""

from __future__ import annotations

import math
from typing import Annotated, Any, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, create_model, model_validator

from engine.brdf.base import Material
from engine.brdf.table import MODELS
from engine.light.environment import EnvironmentDescription
from engine.light.table import AnyLight
from engine.numerics.description import Description, Finite, Point, Reflectance, Unit
from engine.scene.camera import Camera
from engine.scene.shapes import AnyShape

TEXTURE_SLOTS = ("diffuse", "specular", "roughness", "normal")


class Texture(Description):
    """An image in the place of a constant; `factor` multiplies it.

    Images of 8 bits hold sRGB for `diffuse` and `specular` and plain numbers for `roughness`.
    """

    texture: Annotated[str, Field(min_length=1, description="image file beside the description")]
    factor: Unit | Reflectance = 1.0


class NormalMap(Description):
    """An image of normals n, x along u and y along v: red, green and blue are (n + 1) / 2.

    `strength` multiplies x and y.
    """

    texture: Annotated[str, Field(min_length=1, description="image file beside the description")]
    strength: Annotated[float, Field(ge=0, le=10)] = 1.0


def _textured(model: type[Material]) -> type[Material]:
    """The same material with a texture allowed wherever the kernels know how to look one up."""
    fields: dict[str, Any] = {"normal": (NormalMap | None, Field(None, description="a normal map"))}
    for slot in TEXTURE_SLOTS:
        if slot in model.model_fields:
            field = model.model_fields[slot]
            constant: Any = field.annotation
            if field.metadata:
                constant = Annotated[constant, *field.metadata]
            fields[slot] = (constant | Texture, Field(field.default, description=field.description))
    return create_model(model.__name__, __base__=model, __doc__=model.__doc__, **fields)


TEXTURED: dict[type[Material], type[Material]] = {_textured(model): model for model in MODELS}

AnyTexturedMaterial: TypeAlias = Annotated[Union[tuple(TEXTURED)], Field(discriminator="type")]  # type: ignore[valid-type]  # noqa: UP007


def split(described: Material) -> tuple[Material, dict[str, Texture | NormalMap]]:
    """A material as described, into its constants and its textures by slot."""
    constants = described.model_dump(exclude={"normal"})
    textures: dict[str, Texture | NormalMap] = {}
    for slot in TEXTURE_SLOTS:
        texture = getattr(described, slot, None)
        if isinstance(texture, Texture):
            textures[slot] = texture
            factor = np.broadcast_to(texture.factor, 3).tolist()
            constants[slot] = factor[0] if slot == "roughness" else factor
        elif isinstance(texture, NormalMap):
            textures[slot] = texture
    return TEXTURED[type(described)].model_validate(constants), textures


class Transform(Description):
    """Scale first, then rotate, then translate.

    `rotate_degrees` (x, y, z) turns about x, then about y, then about z, all of them the fixed
    axes of the parent, counter-clockwise seen from the tip of the axis: R = R_z R_y R_x.
    """

    translate: Point = (0.0, 0.0, 0.0)
    rotate_degrees: Point = (0.0, 0.0, 0.0)
    scale: Finite | Point = 1.0

    @model_validator(mode="after")
    def _keeps_volume(self) -> Transform:
        if np.any(np.asarray(self.scale) == 0):
            raise ValueError("a scale of 0 leaves nothing of the object")
        return self

    def matrix(self) -> NDArray[np.float64]:
        """(4, 4) for column vectors."""
        result = np.eye(4)
        for axis, degrees in enumerate(self.rotate_degrees):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            i, j = (axis + 1) % 3, (axis + 2) % 3
            turn = np.eye(4)
            turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
            result = turn @ result
        result[:3, :3] = result[:3, :3] * np.broadcast_to(np.asarray(self.scale), 3)
        result[:3, 3] = self.translate
        return result


Row = tuple[Finite, Finite, Finite, Finite]
Matrix = tuple[Row, Row, Row, Row]


class Object(Description):
    """A mesh in its place.

    `mesh` is a file (OBJ, PLY, STL, glTF, GLB) beside the description, or a shape. Without
    `material` the file's own materials hold, or grey where it has none. `transform` may be a
    4 x 4 matrix, row by row, for column vectors.
    """

    name: Annotated[str, Field(min_length=1, max_length=128)]
    mesh: Annotated[str, Field(min_length=1)] | AnyShape
    material: str | None = None
    transform: Transform | Matrix = Transform()

    @model_validator(mode="after")
    def _transform_is_affine(self) -> Object:
        m = self.matrix()
        if not np.array_equal(m[3], [0, 0, 0, 1]):
            raise ValueError("the last row of a transform matrix must be 0 0 0 1")
        if np.linalg.det(m[:3, :3]) == 0:
            raise ValueError("the transform matrix has no inverse: it flattens the object")
        return self

    def matrix(self) -> NDArray[np.float64]:
        """(4, 4) from the object's coordinates to the world, for column vectors."""
        if isinstance(self.transform, Transform):
            return self.transform.matrix()
        return np.array(self.transform, np.float64)


class SceneDescription(Description):
    """A whole scene. Lengths in metres, y up, angles in degrees, linear sRGB.

    Without `camera` one is placed that shows everything; without `lights` and `environment` some
    are made up.
    """

    name: Annotated[str, Field(min_length=1, max_length=128)] = "scene"
    camera: Camera | None = None
    environment: EnvironmentDescription | None = None
    lights: Annotated[list[AnyLight], Field(max_length=4096)] | None = None
    materials: dict[str, AnyTexturedMaterial] = Field(default={})
    objects: Annotated[list[Object], Field(min_length=1)]
