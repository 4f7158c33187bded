"""The table of exact theory: its axes, how it is built, kept and looked up."""
