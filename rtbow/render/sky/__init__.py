"""What is around the drops, drawn over a frame of what they scatter: sky, ground and suns."""
