"""The score as it is told."""
