"""The store of a campaign: one SQLite file of outcomes, and the check which of them are current."""
