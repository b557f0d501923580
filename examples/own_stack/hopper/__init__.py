"""A drone of another author, and what it adds to scaloft-fi: a stack, an operator, a sensor and an export format."""
