"""What lies over the picture, and how it is steered."""
