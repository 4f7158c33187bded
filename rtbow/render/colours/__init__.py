"""Cross-sections summed over a light's spectrum, as method fast looks them up."""
