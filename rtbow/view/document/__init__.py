"""The scene that the window holds: edits, undo, files, recovery."""
