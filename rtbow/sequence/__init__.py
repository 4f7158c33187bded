"""Frames over time: films, numbered frames, and going on after an interruption."""
