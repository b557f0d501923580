"""Coverage against kills: whether situations that cover more combinations of axis values kill more mutants."""
