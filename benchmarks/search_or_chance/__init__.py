"""Does search beat chance?  `python benchmarks/search_or_chance` makes the page."""
