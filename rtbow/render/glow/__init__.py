"""The rain's own glow, added to a frame."""
