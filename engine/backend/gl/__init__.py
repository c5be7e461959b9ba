"""The GL backend: compute shaders of `shaders/`; the only place where moderngl may be used.

| file | what |
|---|---|
| `context` | the one context of the process |
| `source` | shaders with their includes, and errors that name file and line |
| `tables` | which shader belongs to which BRDF and light |
| `bvh` | the tree through which rays find triangles |
| `haar`, `product`, `sums` | the transport: transform, packed rows, element-wise steps |
| `points`, `shading` | direct light |
| `vectors` | transport vectors times a light |
| `raster`, `seen` | what a camera sees |
| `visibility` | what vertices see of the sky |
"""
