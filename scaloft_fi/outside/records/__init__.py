"""Records: what a simulator or a drone wrote during a flight, read into the signals of a flight log."""
