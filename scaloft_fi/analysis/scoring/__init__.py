"""The score: ratios with intervals, decisions over the seeds, false kills, the score part by part."""
