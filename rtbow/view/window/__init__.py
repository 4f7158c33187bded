"""The window itself: its events, its drawing, its looks."""
