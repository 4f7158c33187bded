"""Spectra that users bring: the field's file formats, their units, and what is doubtful in them."""
