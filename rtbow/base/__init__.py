"""What everything else stands on: errors, files, caches, compiled code; no physics and no GL."""
