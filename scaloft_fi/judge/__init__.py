"""Judge a flight log: readings of the requirements, an outcome, a status."""
