"""How long until there is a picture: in direct light, of the preview, of the whole product.

    RELIGHT_STORE=$(mktemp -d) relight serve cornell-box room --port 8000
    python tests/speed/first_picture.py http://127.0.0.1:8000/ room [--method brdf_editing]

In seconds from the first edit on. The service must have an empty store, or nothing is left to wait
for; the scene that it was started with begins by itself.
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any

from websockets.sync.client import connect


def measure(address: str, scene: str, method: str) -> dict[str, float]:
    """Seconds until the first frame of each kind."""
    seconds: dict[str, float] = {}
    url = f"{address.rstrip('/').replace('http', 'ws', 1)}/api/scenes/{scene}/live"
    with connect(url, max_size=None) as socket:
        start = time.monotonic()
        socket.send(json.dumps({"type": "edit", "seq": 1, "method": method}))
        while "whole" not in seconds:
            message = socket.recv()
            if isinstance(message, str):
                told = json.loads(message)
                if "problem" in told or told["job"]["status"] in ("failed", "cancelled"):
                    raise SystemExit(f"no picture: {message}")
                continue
            header = json.loads(message[4 : 4 + int.from_bytes(message[:4], "little")])
            socket.send(json.dumps({"type": "ack", "seq": header["seq"]}))
            seconds.setdefault(kind(header), round(time.monotonic() - start, 1))
    return seconds


def kind(header: dict[str, Any]) -> str:
    """What a frame shows."""
    if header["method"] == "direct":
        return "direct"
    preview = any(warning["code"] == "preview_shown" for warning in header["warnings"])
    return "preview" if preview else "whole"


def main() -> None:
    """Measure and print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("address")
    parser.add_argument("scene")
    parser.add_argument("--method", default="direct_to_indirect")
    print(json.dumps(measure(**vars(parser.parse_args()))))


if __name__ == "__main__":
    main()
