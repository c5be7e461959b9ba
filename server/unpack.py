"""Unpack a zip that somebody sent, into an empty folder and nowhere else.

Only files that a scene may be made of are written, under plain names below the folder, once all
that the zip promises has been checked.
"""

from __future__ import annotations

import re
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from engine.errors import InputError

MAX_ENTRIES = 2000
MAX_BYTES = 1 << 29  # of all files
MAX_RATIO = 200  # of a file to what it was packed to; small ones may have more
SMALL = 1 << 20  # bytes
MAX_DEPTH, MAX_NAME, MAX_PATH = 8, 120, 400
SHOWN = 80  # characters of a name

KINDS = {
    ".json", ".gltf", ".glb", ".bin", ".obj", ".mtl", ".ply", ".stl",
    ".png", ".jpg", ".jpeg", ".webp", ".bmp", ".gif", ".tga", ".tif", ".tiff",
    ".exr", ".hdr", ".brdf", ".binary", ".csv",
}  # fmt: skip
ARCHIVES = {".zip", ".7z", ".rar", ".tar", ".gz", ".tgz", ".bz2", ".xz", ".zst"}
_METHODS = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
_ENCRYPTED = 1
_END, _END_BYTES = b"PK\5\6", 22  # the end of the central directory


def unpack(source: Path, folder: Path) -> None:
    """Write the files of a zip below the folder; InputError, with the entry, for a hostile one."""
    _check_count(source)
    try:
        with zipfile.ZipFile(source) as packed:
            for entry, name in _checked(packed.infolist()):
                _write(packed, entry, folder / name)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, ValueError) as error:
        raise InputError(f"it is not a readable zip ({error})") from None
    except (UnicodeDecodeError, RuntimeError, OSError) as error:
        raise InputError(f"it is not a readable zip ({type(error).__name__})") from None


def _check_count(source: Path) -> None:
    """Before anything is made of the entries: the library makes an object of each."""
    with source.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - _END_BYTES - 0xFFFF))
        tail = file.read()
    end = tail.rfind(_END, 0, len(tail) - _END_BYTES + len(_END))
    if end < 0:
        raise InputError("it is not a zip, or its end is missing")
    count = int.from_bytes(tail[end + 10 : end + 12], "little")
    directory = int.from_bytes(tail[end + 12 : end + 16], "little")
    # An entry of the directory has 46 bytes and its name at least, whatever the count says.
    if count > MAX_ENTRIES or directory > MAX_ENTRIES * (46 + 3 * MAX_PATH):
        raise InputError(f"it has too many entries; {MAX_ENTRIES} are the most")


def _checked(
    entries: list[zipfile.ZipInfo],
) -> Iterator[tuple[zipfile.ZipInfo, PurePosixPath]]:
    """What is to be written and where, once all that the zip says of itself is in order."""
    if len(entries) > MAX_ENTRIES:
        raise InputError(f"it has {len(entries)} entries; {MAX_ENTRIES} are the most")
    total = 0
    wanted: dict[str, tuple[zipfile.ZipInfo, PurePosixPath]] = {}
    for entry in entries:
        shown = _shown(entry.filename)
        mode = entry.external_attr >> 16
        if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise InputError(f"{shown} is a link or no plain file: only files are taken")
        name = _plain(entry.filename)
        if entry.filename.endswith("/") or _is_litter(name):
            continue
        kind = name.suffix.lower()
        if kind in ARCHIVES:
            raise InputError(f"{shown} is packed in itself: put its files into the zip")
        if kind not in KINDS:
            continue
        if entry.flag_bits & _ENCRYPTED:
            raise InputError(f"{shown} is encrypted")
        if entry.compress_type not in _METHODS:
            raise InputError(f"{shown} is packed by another method than deflate")
        total += entry.file_size
        if total > MAX_BYTES:
            raise InputError(f"its files take more than {MAX_BYTES >> 20} MB together")
        if entry.file_size > max(SMALL, MAX_RATIO * entry.compress_size):
            raise InputError(f"{shown} grows more than {MAX_RATIO} times when it is unpacked")
        # Some disks do not tell cases apart.
        if str(name).lower() in wanted:
            raise InputError(f"{shown} is in it twice")
        wanted[str(name).lower()] = entry, name
    for key in wanted:
        if any(str(above) in wanted for above in PurePosixPath(key).parents):
            raise InputError(f"{_shown(key)} lies below a file")
    yield from wanted.values()


def _plain(written: str) -> PurePosixPath:
    """A name below the folder, from one as zips of all systems have it."""
    name, shown = written.replace("\\", "/"), _shown(written)
    if name.startswith("/") or re.match(r"[A-Za-z]:", name):
        raise InputError(f"{shown} is an absolute path: names are those below the zip's folder")
    parts = [part for part in name.split("/") if part not in ("", ".")]
    if ".." in parts:
        raise InputError(f"{shown} leads out of the zip's folder")
    if any(not part.isprintable() or len(part.encode()) > MAX_NAME for part in parts):
        raise InputError(f"{shown} is no name for a file")
    if len(parts) > MAX_DEPTH or len(name.encode()) > MAX_PATH:
        raise InputError(f"{shown} lies too deep")
    return PurePosixPath(*parts)


def _is_litter(name: PurePosixPath) -> bool:
    """What systems leave in zips for themselves."""
    return name.parts[:1] == ("__MACOSX",) or name.name.startswith(".")


def _write(packed: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path) -> None:
    """Write an entry: the library reads no more of it than it promises."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with packed.open(entry) as source, target.open("xb") as file:
        shutil.copyfileobj(source, file)
    if target.stat().st_size != entry.file_size:
        raise InputError(f"{_shown(entry.filename)} is shorter than it says")


def _shown(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in name)[-SHOWN:]
