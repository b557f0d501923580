"""The study's HAZOP: guidewords, parameters and the deviation matrix, read from a study's `hazop/` folder."""
