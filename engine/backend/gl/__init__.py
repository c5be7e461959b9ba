"""The room of the OpenGL backend, the only place where moderngl may be used; empty so far."""
