"""``python -m rtbow``."""

from rtbow.cli.main import main

if __name__ == "__main__":  # processes that the window starts import this, too
    main()
