"""Method spectral: the paper's march with a wavelength loop."""
