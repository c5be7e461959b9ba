"""Which of Mitsuba's variants runs on this machine: the fastest one that does not abort.

`llvm_ad_rgb` is about twice as fast on two cores as `scalar_rgb`, but compiles its kernels with
whatever LLVM the system has, and LLVM 15 and 16 end the process for some of them. So a picture is
tried in a process of its own first.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

FAST, PLAIN = "llvm_ad_rgb", "scalar_rgb"
LIBRARY = "DRJIT_LIBLLVM_PATH"
TRIAL_SECONDS = 120

# A little of all that scenes have; a spot beside a glossy ball is what LLVM 15 fails at.
TRIAL = f"""
import mitsuba as mi
mi.set_variant("{FAST}")
look = mi.ScalarTransform4f().look_at(origin=[0, 0, 0.5], target=[0, -1, 0], up=[0.1, 0.2, 1])
white = {{"type": "rgb", "value": [1.0, 1.0, 1.0]}}
gloss = {{"type": "twosided", "bsdf": {{"type": "roughplastic", "alpha": 0.3}}}}
scene = mi.cornell_box()
scene["spot"] = {{"type": "spot", "to_world": look, "intensity": white}}
scene["ball"] = {{"type": "sphere", "radius": 0.2, "bsdf": gloss}}
scene["sensor"]["film"]["width"] = scene["sensor"]["film"]["height"] = 16
assert mi.render(mi.load_dict(scene), spp=4).array[0] >= 0
"""


@cache
def fastest_variant() -> str:
    """FAST where it works with the LLVM that is named, or else the newest there is; or PLAIN.

    Leaves DRJIT_LIBLLVM_PATH as it worked; call it before Mitsuba is first imported.
    """
    named = os.environ.get(LIBRARY)
    for library in [named] if named else _libraries():
        environment = {**os.environ, LIBRARY: str(library)}
        try:
            trial = subprocess.run(
                [sys.executable, "-c", TRIAL],
                env=environment,
                capture_output=True,
                timeout=TRIAL_SECONDS,
            )
        except subprocess.TimeoutExpired:
            continue
        if trial.returncode == 0:
            os.environ[LIBRARY] = str(library)
            return FAST
    return PLAIN


def _libraries() -> list[Path]:
    """LLVM's shared libraries where Linux keeps them, newest first, one of each version."""
    versions = {
        int(number.group(1)): path
        for path in sorted(Path("/usr/lib").glob("*/libLLVM*.so*"))
        if (number := re.search(r"libLLVM[-.](?:so\.)?(\d+)", path.name))
    }
    return [versions[number] for number in sorted(versions, reverse=True)]
