"""The HAZOP worksheet filled back."""
