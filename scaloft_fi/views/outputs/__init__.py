"""What verbs print for programs: JSON of a declared shape, and the same as CSV, one table a file."""
