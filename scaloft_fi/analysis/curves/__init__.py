"""Coverage against kills."""
