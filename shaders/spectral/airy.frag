#include "drop/airy_theory.glsl"
#include "spectral/pixel.glsl"

// Method `spectral` with Airy's bows, evaluated where the drop is.
