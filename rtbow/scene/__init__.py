"""What a scene is: its tables and keys, checked and frozen."""
