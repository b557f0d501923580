"""The export format: a line of CSV for each mutant."""

from scaloft_fi.api import export_format


@export_format("verdicts", "mutant and whether it is detected, one a line")
def verdicts(dossier):
    """The lines."""
    return "".join(f"{mutant.subject.id},{mutant.detected}\n" for mutant in dossier.score.mutants)
