"""Cross-sections of drops as tables, kept in the cache; host only."""
