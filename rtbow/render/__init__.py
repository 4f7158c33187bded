"""Frames of a world by the methods of the shader."""
