"""What a script or a notebook uses: an open study, its campaigns, flights with their logs, scores, figures."""
