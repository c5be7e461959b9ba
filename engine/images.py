"""Image files: linear float32 RGB in memory, whatever the file holds.

EXR by OpenEXR, Radiance HDR by imagecodecs, JPEG by simplejpeg (writing), the rest by Pillow.
"""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import imagecodecs
import numpy as np
import OpenEXR
import simplejpeg
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from engine.errors import InputError, SceneError
from engine.numerics.display import linear_from_srgb, to_srgb8

_LINEAR = linear_from_srgb(np.arange(256) / 255).astype(np.float32)
MAX_PIXELS = 1 << 28  # of a file
_HDR_SIZE = re.compile(rb"\n[-+]Y (\d{1,9}) [-+]X (\d{1,9})\n")
_HDR_HEADER = 1 << 16  # bytes that a header of the format never fills
_FORMATS = {".exr": "exr", ".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".webp": "webp"}


def read_image(path: Path) -> NDArray[np.float32]:
    """(height, width, 3) float32, linear RGB, top row first.

    EXR and Radiance HDR files are taken as linear, everything else as sRGB; grey is repeated and
    alpha ignored. Raises SceneError, naming the file, where it cannot be read.
    """
    if not path.is_file():
        raise SceneError("there is no such image file", file=str(path))
    reader = {".exr": _read_exr, ".hdr": _read_hdr}.get(path.suffix.lower(), _read_srgb)
    if reader is not _read_srgb:  # Pillow counts itself
        width, height = image_size(path)
        if not 0 < width * height <= MAX_PIXELS:
            raise SceneError(f"{width} x {height} pixels cannot be read", file=str(path))
    image = reader(path)
    if image.size == 0:
        raise SceneError("the image is empty", file=str(path))
    return image


def image_size(path: Path) -> tuple[int, int]:
    """(width, height) of an EXR or Radiance HDR file, from its header alone.

    Raises SceneError, naming the file, where the header cannot be read.
    """
    if path.suffix.lower() == ".exr":
        try:
            with OpenEXR.File(str(path), header_only=True) as file:
                low, high = file.header()["dataWindow"]
        except (RuntimeError, ValueError, KeyError) as error:
            raise _unreadable(path, "EXR", error) from None
        return int(high[0]) - int(low[0]) + 1, int(high[1]) - int(low[1]) + 1
    with path.open("rb") as file:
        found = _HDR_SIZE.search(file.read(_HDR_HEADER))
    if found is None:
        raise SceneError("not a readable Radiance HDR file (no size)", file=str(path))
    return int(found[2]), int(found[1])


def write_image(
    path: Path, image: NDArray[np.float32], exposure: float = 0.0, half: bool = False
) -> None:
    """Write (height, width, 3) linear float32 as .exr, .png, .jpg, .jpeg or .webp.

    EXR files hold the radiance itself, in float32 or half precision; the others hold what a screen
    shows at an exposure in stops. Raises InputError, naming the file, where it cannot be written.
    """
    kind = format_of(path)
    try:
        if kind == "exr":
            path.write_bytes(encode_exr(image, half))
        else:
            path.write_bytes(encode(to_srgb8(image, exposure), kind, 95))
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(path)) from None


def format_of(path: Path) -> str:
    """What `write_image` would write there; InputError, naming the file, where it would not."""
    kind = _FORMATS.get(path.suffix.lower())
    if kind is None:
        known = ", ".join(_FORMATS)
        raise InputError(f"the name of an image must end in one of {known}", file=str(path))
    if not path.parent.is_dir():
        raise InputError("there is no such folder", file=str(path))
    return kind


def encode(image: NDArray[np.uint8], format: str, quality: int = 90) -> bytes:
    """Bytes of a "jpeg", "png" or "webp" file of (height, width, 3) uint8, sRGB.

    quality 1 to 100 is that of JPEG and WebP; JPEG keeps colour at full resolution from 90 on.
    """
    if format == "jpeg":
        sampling = "444" if quality >= 90 else "420"
        return simplejpeg.encode_jpeg(np.ascontiguousarray(image), quality, "RGB", sampling)
    buffer = io.BytesIO()
    if format == "png":
        Image.fromarray(image).save(buffer, "PNG", compress_level=1)
    elif format == "webp":
        Image.fromarray(image).save(buffer, "WEBP", quality=quality, method=2)
    else:
        raise ValueError(f"image format {format!r} is none of 'jpeg', 'png', 'webp'")
    return buffer.getvalue()


def encode_exr(image: NDArray[np.float32], half: bool = False) -> bytes:
    """Bytes of an EXR file of (height, width, 3) linear float32, lossless but for `half`.

    Half precision has 11 bits and ends at 65504; what is brighter becomes that.
    """
    pixels = np.ascontiguousarray(image, np.float32)
    if half:
        pixels = np.clip(pixels, -65504, 65504).astype(np.float16)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    # The library writes to a path alone.
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.exr"
        with OpenEXR.File(header, {"RGB": pixels}) as file:
            file.write(str(path))
        return path.read_bytes()


def _read_exr(path: Path) -> NDArray[np.float32]:
    try:
        with OpenEXR.File(str(path)) as file:
            planes = {name: channel.pixels for name, channel in file.channels().items()}
    except (RuntimeError, ValueError) as error:  # ValueError: no part could be read whole
        raise _unreadable(path, "EXR", error) from None
    for name in ("RGB", "RGBA", "Y", "YA"):
        if name in planes:
            return _three_channels(np.asarray(planes[name], np.float32))
    raise SceneError(f"no R, G, B among its channels {', '.join(planes)}", file=str(path))


def _read_hdr(path: Path) -> NDArray[np.float32]:
    data = path.read_bytes()
    if b"32-bit_rle_xyze" in data[:512]:
        raise SceneError("XYZE colours are not supported; save it as RGBE", file=str(path))
    return _decoded(path, lambda: imagecodecs.rgbe_decode(data), "Radiance HDR")


def _read_srgb(path: Path) -> NDArray[np.float32]:
    def decode() -> NDArray[np.float32]:
        with Image.open(path) as image:
            if image.mode == "F":
                return np.asarray(image)
            if image.mode.startswith("I"):  # 16 bits of grey, which `convert` would cut off
                return linear_from_srgb(np.asarray(image) / 65535).astype(np.float32)
            return _LINEAR[np.asarray(image.convert("RGB"))]

    return _decoded(path, decode, "image")


def _decoded(
    path: Path, decode: Callable[[], NDArray[np.float32]], kind: str
) -> NDArray[np.float32]:
    """decode(), with what decoders raise on damaged data turned into SceneError."""
    try:
        return _three_channels(decode())
    except (
        UnidentifiedImageError,
        Image.DecompressionBombError,
        imagecodecs.RgbeError,
        OSError,
        SyntaxError,
        ValueError,
    ) as error:
        raise _unreadable(path, kind, error) from None


def _unreadable(path: Path, kind: str, error: Exception) -> SceneError:
    """What a decoder said, without the folder: who hears of it need not know where files lie."""
    said = str(error).replace(str(path), path.name)
    return SceneError(f"not a readable {kind} file ({said})", file=str(path))


def _three_channels(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(height, width, 3) of (height, width) or (height, width, 1 to 4)."""
    if image.ndim == 2:
        image = image[:, :, None]
    if image.shape[2] < 3:
        image = np.repeat(image[:, :, :1], 3, axis=2)
    return np.ascontiguousarray(image[:, :, :3])
