"""The names that stand where a user names none."""

CAMPAIGN = "default"
"""The campaign that verbs fly and read."""
SEARCHED = "search"
"""The grid that `seek` searches."""
