"""Does search beat chance?  `python -m experiments.search_or_chance` makes the page."""
