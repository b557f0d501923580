"""What a study has, told without flying: its signals, seams, operators and axes."""
