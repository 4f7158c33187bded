"""Method reference: the radiance integral in float64 on the CPU."""
