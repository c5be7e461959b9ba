"""Scenes: description, loading, built-in scenes, camera, meshes and rays."""
