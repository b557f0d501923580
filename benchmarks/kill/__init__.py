"""A campaign that is killed again and again."""
