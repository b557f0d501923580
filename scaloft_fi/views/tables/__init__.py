"""Tables as data, and how they are printed."""
