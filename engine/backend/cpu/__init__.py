"""The CPU backend: Numba kernels and Embree rays on all cores."""
