"""What a campaign holds, and under which keys."""
