#include "drop/table_theory.glsl"
#include "spectral/pixel.glsl"

// Method `spectral` with cross-sections from a table made for the scene.
