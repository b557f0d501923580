"""Flights as rows, and two campaigns side by side."""
