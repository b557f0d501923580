"""Search for a situation that shows a fault: how near a situation is, and whether fresh seeds confirm it."""
