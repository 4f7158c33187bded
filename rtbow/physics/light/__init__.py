"""Spectra, colours, discs of light and where the sun stands."""
