"""Operators for messages that only the reference stack has."""
