"""Transport vectors of neighbouring vertices in a basis of their own: `glossy_prt` §6.

What the paper leaves for later. See `engine.numerics.cluster_basis`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.numerics.cluster_basis import cluster
from engine.numerics.wavelet_vectors import WaveletVectors, white_light


@dataclass(frozen=True)
class Job:
    """The vectors of one material.

    start   (v + 1,) of the vectors
    bounds  (clusters + 1,) which of the vectors each cluster has
    weight  (c,) how much the channels count against each other
    error   see `cluster_basis`
    """

    vectors: WaveletVectors
    start: NDArray[np.int64]
    bounds: NDArray[np.int32]
    weight: NDArray[np.float32]
    light_texels: int
    error: float


def cluster_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """The vectors of a cluster, as the arrays of `Clusters`."""
    v = job.vectors
    rows = slice(job.bounds[chunk], job.bounds[chunk + 1])
    places = slice(job.start[rows.start], job.start[rows.stop])
    part = WaveletVectors(
        v.length[rows], v.base[rows], v.scale[rows], v.place[places], v.steps[places]
    )
    return cluster(part, white_light(job.light_texels), job.weight, job.error)._asdict()
