"""The progress of a run, shown to the user."""
