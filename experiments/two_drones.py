"""Fly the whole matrix on the second drone, and hold what it shows against what the reference drone shows.

    python -m experiments.two_drones [--picture]

The second drone is the frozen one of `documented.md`.  Flies nothing: the page, and the comparison beside it, are made
from two published archives, that of the reference campaign and `results/published/second_drone/`, which has its study.
`--picture` takes a picture of the comparison: that needs `chromium` on the path and the packages of the extra `test`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import product

from experiments import PUBLISHED, ROOT
from experiments.pages import Row, blocks, parser, registered, table
from experiments.reference import REFERENCE, pictured
from scaloft_fi.analysis.comparison import Change, ComparedCampaigns, ComparedMutant, Flown, compared, of_seeds
from scaloft_fi.analysis.detection import State, Verdict
from scaloft_fi.analysis.score import score_of
from scaloft_fi.hazop.matrix import Matrix, class_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import agreement_text, compared_by, matrices_page, too_few
from scaloft_fi.verbs.snapshot import Snapshot, snapshot

NAME = "two_drones"
SECOND = PUBLISHED / "second_drone"
SEEDS = 3
COMPARISON, PICTURE = PUBLISHED / "two_matrices.html", PUBLISHED / "two_matrices.png"


def results(study: Study) -> tuple[str, str]:
    """The section with the results, and the page with both matrices."""
    told, matrix, _ = compared_by(study, str(REFERENCE), str(SECOND), flights=False)
    with snapshot(study, str(REFERENCE)) as reference, snapshot(study, str(SECOND)) as second:
        both = [*zip(figures(reference), figures(second), strict=True)]
        left_out = [_without(reference, second, seed) for seed in range(SEEDS)]
    text = blocks(
        "## Flown",
        table(("", "reference drone", "second drone"), ((name, one, two) for (name, one), (_, two) in both)),
        counted(told.scores),
        *differences(told.scores, "reference drone", "second drone", "reference", "second"),
        "### With one seed of the mutants left out",
        table(("seed", "shown on the reference drone", "on the second", "lost", "gained", "unsure", "agree"), left_out),
        "### Every fault",
        table(
            ("parameter", "faults", "both show", "reference alone", "second alone", "neither"),
            _by_parameter(told.scores.mutants, matrix),
        ),
    )
    return text, matrices_page(told.scores, matrix)


def figures(now: Snapshot) -> list[tuple[str, str]]:
    """What a campaign shows, as names and numbers."""
    score = now.score
    counted, states = score.counted, Counter(score.pool.states.values())
    firm = [one for one in counted if one.firm]
    tested = [one for one in counted if one.tested]
    verdicts = Counter(one.verdict for one in counted)
    return [
        ("faults that the safety requirements show", f"{verdicts[Verdict.DETECTED]} of {len(counted)}"),
        ("of these firm: without any one seed too", f"{len(firm)}"),
        ("put to the test", f"{len(tested)}"),
        ("put to the test and not shown", f"{verdicts[Verdict.NOT_DETECTED]}"),
        ("undecided", f"{verdicts[Verdict.UNDECIDED]}"),
        ("pairs of situation and requirement that are steady", f"{states[State.STEADY]}"),
        ("pairs that are red", f"{states[State.RED]}"),
    ]


def _without(reference: Snapshot, second: Snapshot, seed: int) -> Row:
    """What remains of the comparison without one seed of the mutants; the pools stay."""
    kept = [one for one in range(SEEDS) if one != seed]
    flown = []
    for now in (reference, second):
        rulings = of_seeds(now.rulings, kept)
        flown.append(Flown(now.name, rulings, score_of(rulings, now.study.roster, now.study.space)))
    told = compared(flown[0], flown[1], reference.study.roster, reference.study.space)
    shown = [sum(mutant.detected for mutant in one.score.counted) for one in flown]
    lost, gained = (", ".join(ids) or "-" for ids in (told.lost, told.gained))
    return (seed, *shown, lost, gained, len(told.unsure), told.agreement.same)


def counted(told: ComparedCampaigns) -> str:
    """How many faults are lost, gained and unsure, what could have been, and the agreement, in a sentence each."""
    count = Counter(one.change for one in told.mutants)
    parts = ", ".join(f"{count[change]} {change}" for change in (Change.LOST, Change.GAINED, Change.UNSURE))
    return "  ".join((f"{parts}, of {len(told.mutants)} faults.", *too_few(told), agreement_text(told)))


def differences(told: ComparedCampaigns, *names: str) -> Iterator[str]:
    """A section for what is lost, gained and unsure: `names` head the two verdicts and the two counts of flights."""
    for change in (Change.LOST, Change.GAINED, Change.UNSURE):
        mutants = [one for one in told.mutants if one.change is change]
        if mutants:
            head = ("severity", "mutant", *names[:2], "p", "violates", *names[2:])
            yield "\n".join([f"### {change.capitalize()}", "", *table(head, map(_row, mutants))])


def _row(one: ComparedMutant) -> Row:
    first = one.first is Verdict.DETECTED
    p = one.lost_p if first else one.gained_p
    verdicts = [
        f"{verdict.words}, firm" if firm else verdict.words
        for verdict, firm in ((one.first, one.first_firm), (one.second, one.second_firm))
    ]
    counts = one.requirement or "-", one.first_violated.short, one.second_violated.short
    return (class_of(one.severity), one.id, *verdicts, f"{p:.2g}", *counts)


def _by_parameter(mutants: Sequence[ComparedMutant], matrix: Matrix) -> Iterator[Row]:
    for parameter in (entry.id for entry in matrix.parameters):
        own = [one for one in mutants if one.subject.parameter == parameter]
        pairs = Counter((one.first is Verdict.DETECTED, one.second is Verdict.DETECTED) for one in own)
        yield parameter, len(own), *(pairs[one, other] for one, other in product((True, False), repeat=2))


def main() -> None:
    """Write the page and the comparison."""
    asked = parser(__doc__, NAME)
    asked.add_argument("--picture", action="store_true", help="take a picture of the comparison")
    options = asked.parse_args()
    text, page = results(Study.open(ROOT))
    options.output.write_text(registered(NAME) + text, encoding="utf-8")
    COMPARISON.write_text(page, encoding="utf-8")
    if options.picture:
        pictured(COMPARISON, "main", PICTURE)


if __name__ == "__main__":
    main()
