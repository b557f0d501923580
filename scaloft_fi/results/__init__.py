"""From flight logs to readings, statuses, scores and tables: pure functions over stored outcomes."""
