"""What verbs say of a frame: in a few lines, and as JSON."""
