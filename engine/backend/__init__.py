"""Where pixels and products are computed: `cpu` by Numba and Embree, `gl` by OpenGL."""
