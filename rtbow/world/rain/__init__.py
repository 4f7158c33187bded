"""The drops of a scene: their sizes, their grid and what they take out of the light."""
