"""Light, drops and air in NumPy: no scene, no GL."""
