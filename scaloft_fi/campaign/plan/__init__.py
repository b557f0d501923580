"""What is flown, in which order, in which pieces."""
