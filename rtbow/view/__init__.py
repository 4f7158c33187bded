"""The live window. It knows the renderer; the renderer does not know it."""
