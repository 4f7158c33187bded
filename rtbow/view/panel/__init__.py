"""The panel's controls."""
