"""The dry check of a whole study: every part on its own, every finding with place and remedy, nothing flown."""
