"""The store: entries by key, in a folder of this machine or wherever RELIGHT_STORE says."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from pathlib import Path
from urllib.parse import unquote, urlsplit

import platformdirs

from engine.store.entry import Entry, checked
from engine.store.folder import FolderEntry
from engine.store.remote import RemoteEntry, opened

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:(//|:)")


class Store:
    """A folder of entries: RELIGHT_STORE, or the user's cache folder.

    root   a folder of this machine, which has room for other things beside the entries; where the
           store is elsewhere, that of the copies of what was read
    where  what to call the store
    """

    def __init__(self, root: Path | str | None = None) -> None:
        """Nothing is created before the first write; a string may be a URL, see `remote`."""
        asked = root or os.environ.get("RELIGHT_STORE")
        cache = platformdirs.user_cache_path("relight")
        self._remote: tuple[object, str] | None = None
        if not isinstance(asked, str) or not _URL.match(asked):
            self.root = Path(asked or cache / "store")
        elif urlsplit(asked).scheme == "file":
            self.root = Path(unquote(urlsplit(asked).path))
        else:
            self._remote = opened(asked)
            digest = hashlib.blake2b(asked.encode(), digest_size=8).hexdigest()
            self.root = cache / "copies" / digest
        self.where = str(self.root) if self._remote is None else _without_password(str(asked))

    def entry(self, key: str) -> Entry:
        """The entry of a key, such as a content hash; raises InputError for what is no key."""
        checked("key", key)
        if self._remote is None:
            return FolderEntry(self.root / key)
        files, folder = self._remote
        return RemoteEntry(files, f"{folder.rstrip('/')}/{key}", self.root / key)

    def remove(self) -> None:
        """Remove a folder of this machine; arrays that are still mapped stay valid."""
        shutil.rmtree(self.root, ignore_errors=True)


def _without_password(url: str) -> str:
    return re.sub(r"//[^/@]*@", "//", url)
