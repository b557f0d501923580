"""From a planned flight to its outcome."""
