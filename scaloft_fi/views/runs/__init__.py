"""What a run tells besides the score."""
