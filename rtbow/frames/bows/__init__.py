"""The bows of a frame: where they stand, how they measure, and why none shows."""
