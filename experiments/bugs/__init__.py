"""Real bugs of flight software, each written into a copy of the reference stack as its fix shows it."""
