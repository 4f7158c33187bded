"""The version of rtbow."""

__version__ = "0.1.0"
