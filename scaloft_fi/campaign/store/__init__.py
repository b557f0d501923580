"""What a campaign has flown: one SQLite file, and which of its outcomes still stand."""
