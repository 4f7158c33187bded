"""``python -m rtbow``."""

from rtbow.cli import main

main()
