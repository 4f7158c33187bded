"""Method fast: colours integrated over wavelengths ahead of the march."""
