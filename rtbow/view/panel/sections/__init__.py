"""Parts of the panel that the schema of the scene does not make."""
