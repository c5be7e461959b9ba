"""How fast and how true: error metrics, timings, sweeps, charts and benchmarks."""
