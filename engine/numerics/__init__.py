"""Numbers that know nothing of scenes: vectors, frames, sampling, Haar, parallel loops."""
