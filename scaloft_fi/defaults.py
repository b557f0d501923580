"""The version of this package, the names that stand where a user names none, and how seeds are named."""

__version__ = "0.1.0"
"""`docs/api.md` says what changes which of its numbers."""
Seeds = int | str | range | list[int] | tuple[int, ...]
"""`3` or `"3"` for seeds 0 to 2, `"4-6"` for seeds 4 to 6, or the seeds themselves."""
CAMPAIGN = "default"
"""The campaign that verbs fly and read."""
SEARCHED = "search"
"""The grid that `seek` searches."""
