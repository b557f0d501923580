"""The version of this package; `docs/api.md` says what changes which of its numbers."""

__version__ = "0.1.0"
