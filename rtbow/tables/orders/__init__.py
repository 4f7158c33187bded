"""Light that rain scatters more than once."""
