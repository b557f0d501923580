"""From a flight log to readings, an outcome and a status."""
