"""The reference stack: our drone, a stack like any other."""
