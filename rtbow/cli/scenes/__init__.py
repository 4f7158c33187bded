"""Verbs that make scenes."""
