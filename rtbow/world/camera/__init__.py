"""What a camera sees: its picture on the sphere of directions, by projection."""
