"""The service: HTTP and the live socket over the engine."""
