"""Every type that crosses the wire, for HTTP and for the live socket.

Live socket, client to service: JSON text, `LiveEdit` or `LiveAck`. Service to client: a binary
message per frame (4 bytes little-endian length of the header, `FrameHeader` as JSON, the encoded
image), and JSON text: `LiveJob` when the precompute of the view moves on, `LiveProblem` when an
edit could not be drawn.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from engine.diagnosis import Diagnosis
from engine.measure.front import FrontPoint
from engine.measure.verdict import Verdict
from engine.scene.camera import Camera
from engine.scene.edits import Edits

ImageFormat = Literal["jpeg", "png", "webp", "exr"]
JobStatus = Literal["queued", "running", "done", "failed", "cancelled"]
Work = Literal["product", "front", "reference"]
Shown = Literal["live", "reference", "difference"]

Exposure = Annotated[float, Field(ge=-32, le=32, description="in stops: doubles per unit")]
Scale = Annotated[int, Field(ge=1, le=2, description="2 draws every second pixel and row")]
Place = Annotated[float, Field(ge=0, le=1, description="from the left or top edge of the picture")]
Quality = Annotated[int, Field(ge=1, le=100, description="of JPEG and WebP; PNG has none")]


class Wire(BaseModel):
    """Unknown keys, NaN and infinity are refused; what the service sends never changes."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Problem(Wire):
    """RFC 9457, with the dotted path of the field and the file that are to blame."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    field: str = ""
    file: str = ""


class Notice(Wire):
    """A diagnosis."""

    code: str
    message: str
    size: float = 0.0

    @staticmethod
    def of(diagnosis: Diagnosis) -> Notice:
        """From the engine's diagnosis."""
        return Notice(**{**vars(diagnosis), "size": min(diagnosis.size, 1e30)})


class SceneSummary(Wire):
    """A scene in the list; `default` is the one that the page opens, `sent` came by POST."""

    name: str
    description: str
    default: bool
    sent: bool


class MethodState(Wire):
    """A method as offered for one scene; `ready` for the scene's own camera.

    models    types of material that its edits of materials may choose
    settings  those that a frame may ask for, and their defaults
    """

    name: str
    paper: str
    edits: list[str]
    models: list[str]
    settings: dict[str, Any]
    ready: bool
    bytes: int = 0


class MapSummary(Wire):
    """An environment map that was sent: `name` for edits, `label` for people."""

    name: str
    label: str
    width: int
    height: int


class MeasuredSummary(Wire):
    """A measured material to choose: `name` for edits, `label` for people, where it is from."""

    name: str
    label: str
    kind: Literal["built_in", "beside", "upload"]


class MeasuredSent(Wire):
    """A measured material that was sent, and what its user should know of it."""

    material: MeasuredSummary
    diagnoses: list[Notice]


class EnvironmentDetail(Wire):
    """The scene's own environment, None where there is none; what else it may be.

    maps        names of built-in ones and of files in the scene's folder
    uploads     maps that were sent to the service; besides all these a map may be a radiance
                [r, g, b] or what the JSON schema `sky` describes
    area_light  JSON schema
    """

    description: dict[str, Any] | None
    maps: list[str]
    uploads: list[MapSummary]
    sky: dict[str, Any]
    area_light: dict[str, Any]


class MaterialDetail(Wire):
    """A material as it is; how the method models it once its product is there, else None.

    curve                          the same as a `half_angle_curve`, for a hand to bend
    terms, channels, error, bytes  see `engine.methods.base.MaterialFit`
    """

    name: str
    description: dict[str, Any]
    curve: dict[str, Any]
    terms: int | None = None
    channels: int | None = None
    error: float | None = None
    bytes: int | None = None


class Picked(Wire):
    """What a place of the picture shows, None where nothing is."""

    material: str | None


class SceneDetail(Wire):
    """What can be seen and edited in a scene; `light_types` has a JSON schema per type.

    `material_types` the same of materials; `material_presets` are groups of materials by name, as
    edits take them; `measured` is what a measured one may be.
    """

    name: str
    description: str
    camera: Camera
    diagonal: float
    lights: list[dict[str, Any]]
    light_types: dict[str, dict[str, Any]]
    environment: EnvironmentDetail
    materials: list[str]
    material_types: dict[str, dict[str, Any]]
    material_presets: dict[str, dict[str, dict[str, Any]]]
    measured: list[MeasuredSummary]
    objects: list[str]
    triangles: int
    methods: list[MethodState]
    warnings: list[Notice]
    job: JobState | None


class FrameHeader(Wire):
    """What goes along with a frame; timings in milliseconds.

    method  `direct` while the indirect light is not there yet
    error   estimated relative error of the method, None where none is known
    job     id of the precompute that this view waits for
    """

    seq: int
    width: int
    height: int
    scale: int
    format: ImageFormat
    method: str
    timings: dict[str, float]
    warnings: list[Notice]
    error: float | None = None
    job: str | None = None


class PrecomputeRequest(Wire):
    """Which method to prepare, for the camera and the materials of `edits`.

    settings  in place of the usual ones; None are those of its last precompute for the scene
    """

    method: str = "direct_to_indirect"
    settings: dict[str, Any] | None = None
    edits: Edits = Edits()


class JobState(Wire):
    """Long work: `fraction` and `eta_seconds` are those of the phase, None while unknown.

    work     a method's product, what its settings cost, or a reference picture
    preview  whether frames have a preview of the product until then
    """

    id: str
    work: Work = "product"
    scene: str
    method: str
    status: JobStatus
    phase: str = ""
    fraction: float = 0.0
    elapsed_seconds: float = 0.0
    eta_seconds: float | None = None
    preview: bool = False
    problem: Problem | None = None


class Chart(Wire):
    """Speed against accuracy of a method on a scene.

    kinds    which edits it is judged by; none where the scene has nothing that it edits
    points   none while it was not measured
    current  which point has the settings that frames have, or would have; None where none has
    job      that measures it
    """

    scene: str
    method: str
    kinds: list[str]
    points: list[FrontPoint]
    current: int | None = None
    job: JobState | None = None


class ReferenceResult(Wire):
    """How far a frame was off; the pictures lie beside it, see `Shown`.

    method            that drew the frame
    samples, seconds  that the reference took, per pixel and in all
    full, averaged    see `engine.measure.false_colour.Difference`
    """

    method: str
    verdict: Verdict
    samples: int
    seconds: float
    full: float
    averaged: int


class LiveEdit(Wire):
    """The whole state that the client wants to see; a newer one replaces an older one.

    settings  see `MethodState`
    """

    type: Literal["edit"] = "edit"
    seq: Annotated[int, Field(ge=0, lt=2**53)]
    edits: Edits = Edits()
    exposure: Exposure = 0.0
    scale: Scale = 1
    format: Literal["jpeg", "png", "webp"] = "jpeg"
    quality: Quality = 85
    method: str = "direct_to_indirect"
    settings: dict[str, Any] = {}


class LiveAck(Wire):
    """The client has shown, or thrown away, one frame; the service may send another."""

    type: Literal["ack"] = "ack"
    seq: Annotated[int, Field(ge=0, lt=2**53)]


LiveMessage = Annotated[LiveEdit | LiveAck, Field(discriminator="type")]


class LiveJob(Wire):
    """The precompute of the client's view has moved on."""

    type: Literal["job"] = "job"
    job: JobState


class LiveProblem(Wire):
    """The edit with this number, or an unreadable message (-1), could not be answered."""

    type: Literal["problem"] = "problem"
    seq: int = -1
    problem: Problem


SceneDetail.model_rebuild()
