"""A few lines for scripts and notebooks that ask a service for pictures, over httpx.

    relight = Relight()
    relight.prepare("cornell-box")
    relight.frame("cornell-box", lights=[{"id": "key", "intensity": [0.3, 0.2, 0.1]}])

A notebook shows the picture; `np.asarray` has its pixels. httpx is in the extra `client`.
"""

from __future__ import annotations

import io
import json
import time
from types import TracebackType
from typing import Any

import httpx
from PIL import Image

from engine.errors import RelightError

TRIES = 5  # where the service says that it is busy
WAIT_SECONDS = 0.5


class Relight:
    """A service that runs at an address; what it refuses is raised as RelightError."""

    def __init__(self, address: str = "http://127.0.0.1:8000", token: str | None = None) -> None:
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        self._http = httpx.Client(base_url=address, headers=headers, timeout=60)

    def scenes(self) -> list[str]:
        """Names of the scenes; the default one first."""
        return [scene["name"] for scene in self._ask("GET", "/api/scenes").json()]

    def scene(self, scene: str) -> dict[str, Any]:
        """Its camera, lights, environment and materials, as edits call them, and its methods."""
        found: dict[str, Any] = self._ask("GET", f"/api/scenes/{scene}").json()
        return found

    def prepare(
        self,
        scene: str,
        method: str = "direct_to_indirect",
        settings: dict[str, Any] | None = None,
        **edits: Any,
    ) -> None:
        """Have the method's product precomputed, and wait for it; until then frames are direct.

        edits are a camera, and materials for a method that holds them fixed.
        """
        body = {"method": method, "settings": settings, "edits": edits}
        job = self._ask("POST", f"/api/scenes/{scene}/precompute", json=body).json()
        while job["status"] in ("queued", "running"):
            time.sleep(WAIT_SECONDS)
            job = self._ask("GET", f"/api/jobs/{job['id']}").json()
        if job["status"] != "done":
            problem = job["problem"] or {"detail": "somebody stopped it"}
            raise RelightError(f"the precompute {job['status']}: {problem['detail']}")

    def frame(
        self,
        scene: str,
        *,
        exposure: float = 0.0,
        method: str = "direct_to_indirect",
        settings: dict[str, Any] | None = None,
        **edits: Any,
    ) -> Image.Image:
        """The scene under edits: `lights`, `environment`, `materials`, `camera`, as in a scene.

        `info` of the picture has the frame's header: what drew it, times, warnings.
        """
        query = {"exposure": exposure, "method": method, "settings": json.dumps(settings or {})}
        answer = self._ask(
            "POST", f"/api/scenes/{scene}/frame", json=edits, params=query,
            headers={"Accept": "image/png"},
        )  # fmt: skip
        image = Image.open(io.BytesIO(answer.content))
        image.load()
        image.info.update(json.loads(answer.headers["Relight-Frame"]))
        return image

    def close(self) -> None:
        """Close the connection."""
        self._http.close()

    def __enter__(self) -> Relight:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:  # fmt: skip
        self.close()

    def _ask(self, method: str, path: str, **more: Any) -> httpx.Response:
        """The answer; tried again where the service says when to come back."""
        for _ in range(TRIES):
            answer = self._http.request(method, path, **more)
            if answer.status_code not in (429, 503):
                break
            time.sleep(float(answer.headers.get("Retry-After", 1)))
        if answer.is_error:
            problem = answer.json()
            field = f"{problem['field']}: " if problem.get("field") else ""
            raise RelightError(f"{field}{problem['detail']}")
        return answer
