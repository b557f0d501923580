"""The score for readers."""
