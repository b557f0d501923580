"""What kills what, and what is to be done about the rest, as it is told."""
