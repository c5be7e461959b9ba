"""Every error that Relight raises on purpose.

RelightError                 anything below; `str(error)` is a sentence a person can act on
├── InputError               bad input: a file, a field, a value (HTTP 422)
│   ├── SceneError           a scene description or a mesh, names file and field
│   └── EditError            an edit that does not fit the scene, names the field
│       └── EditNotSupported the method cannot take this edit; names the one that can
├── NotFound                 no such scene, job or method (HTTP 404)
├── StoreError               a stored product is damaged, or the store refuses; names the file
├── BackendError             GL is missing or was lost; the message says what to install
└── Cancelled                somebody asked the work to stop
"""

from __future__ import annotations

import errno

REFUSED = {errno.ENOSPC, errno.EDQUOT, errno.EROFS}
"""Of an OSError: the disk is full or may not be written, which is for the user to mend."""


class RelightError(Exception):
    """Base of every error raised on purpose."""


class InputError(RelightError):
    """Bad input. `field` is a dotted path such as `lights.0.intensity`, `file` a file name."""

    def __init__(self, message: str, *, field: str = "", file: str = "") -> None:
        self.message, self.field, self.file = message, field, file
        where = ", ".join(part for part in (file, field) if part)
        super().__init__(f"{where}: {message}" if where else message)


class SceneError(InputError):
    """A scene description, a mesh or a texture that cannot be used."""


class EditError(InputError):
    """An edit that does not fit the scene."""


class EditNotSupported(EditError):
    """The product cannot take this edit."""


class NotFound(RelightError):
    """No such scene, job or method."""


class StoreError(RelightError):
    """A stored product is damaged or of another version, or the store refuses.

    `file` is where it lies: for the user of this machine, not for those of a service.
    """

    def __init__(self, message: str, *, file: str = "") -> None:
        self.message, self.file = message, file
        super().__init__(f"{file}: {message}" if file else message)


class BackendError(RelightError):
    """A rendering backend is missing or was lost."""


class Cancelled(RelightError):
    """Somebody asked the work to stop."""
