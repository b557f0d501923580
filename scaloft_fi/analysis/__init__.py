"""What follows from outcomes: scores, margins, coverage, kills.  Pure functions: no files, no text."""
