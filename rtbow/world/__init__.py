"""A scene resolved: every light, drop and column that a method needs, computed once."""
