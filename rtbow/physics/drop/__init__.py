"""What one drop does to light: water's index, Airy's theory and Lorenz and Mie's."""
