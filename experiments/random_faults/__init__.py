"""Random faults beside the faults of the deviation matrix: the draw, the plan, the flights and the comparison."""
