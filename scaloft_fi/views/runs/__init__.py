"""What a run prints besides the score."""
