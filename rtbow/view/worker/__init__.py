"""The process that renders for the window."""
