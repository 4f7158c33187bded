"""Attenuation by the air."""
