"""How a scene is read from TOML text, changed by overrides, and refused."""
