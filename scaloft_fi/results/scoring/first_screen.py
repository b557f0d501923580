"""The first screen after `run` and `score`: four answers, the mutants by verdict, what was covered, what the drone does.

All of it fits 100 columns.  Long groups are cut unless everything is asked for; the other tables stand behind `--all`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from textwrap import fill, indent

from scaloft_fi.results.kills.background import Background
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.roster import Roster, cell_of
from scaloft_fi.results.scoring.answers import Answer, answers
from scaloft_fi.results.scoring.detection import Verdict
from scaloft_fi.results.scoring.pool import Pool, State
from scaloft_fi.results.scoring.score import MutantScore, Score
from scaloft_fi.results.situations.coverage import Coverage
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Status
from scaloft_fi.results.telling.table import WIDTH, Table

MANY, SHOWN = 30, 10
"""Of more mutants than `MANY` each group shows its first `SHOWN`."""
HEADERS = ("mutant", "kills", "by", "where", "first", "effect", "next")
TITLE = "Would your tests have shown it?"
LEGEND = (
    "kills: situations where most flights of a detected mutant violate a safety requirement that the unmutated drone",
    "  holds in nine of ten flights, of the situations that put the mutant to the test; seen: a violation there.",
    "by: requirements with their kills, of the situations where each was a test; first: seconds from take-off.",
    "next: what `scaloft-fi` verb to call; details of one mutant: `scaloft-fi kills ID`, all tables: `score --all`.",
)
_STOPPED = {
    Status.INVALID: "the harness failed",
    Status.NOT_REACHED: "its seam carries nothing",
    Status.NOT_INFECTED: "changes no sample",
    Status.MASKED: "flies the same to the bit",
    Status.BASELINE_RED: "violates as the baseline",
    Status.SURVIVED: "flies otherwise",
    Status.REVEALED: "flies otherwise",
}


def first_screen(
    scored: Score,
    roster: Roster,
    space: Space,
    covered: Coverage,
    backgrounds: Mapping[str, Background],
    *,
    campaign: str = "default",
    whole: bool = False,
) -> tuple[Table, ...]:
    """The screen as tables: the answers, a table a group, and the two lines.

    Args:
        scored: the campaign's score.
        roster: which mutants count.
        space: the grid.
        covered: its situation coverage.
        backgrounds: of the mutants, by id.
        campaign: its name, for the commands.
        whole: whether groups are shown to their ends.
    """
    told = answers(scored, roster, campaign)
    lines = (Answer("Situations", coverage_line(covered)), Answer("Unmutated drone", baseline_line(scored.pool)))
    rows = {mutant.subject.id: _row(mutant, space, backgrounds.get(mutant.subject.id)) for mutant in _told(scored)}
    groups = [_group(title, listed, rows, whole) for title, listed in _groups(scored).items() if listed]
    if groups:
        groups[-1] = Table(groups[-1].title, groups[-1].headers, groups[-1].rows, (*groups[-1].notes, *LEGEND))
    return (
        Table(TITLE, ("question", "answer"), tuple(told)),
        *groups,
        Table("Besides", ("what", "finding"), lines),
    )


def heading(table: Table) -> str:
    """A table of two columns as lines of text: what a terminal shows of the answers."""
    wide = max(len(str(name)) for name, _ in table.rows) + 2
    lines = [
        str(name).ljust(wide) + indent(fill(str(text), WIDTH - wide), " " * wide).lstrip() for name, text in table.rows
    ]
    return "\n".join(lines) + "\n"


def coverage_line(covered: Coverage) -> str:
    """The situations in a sentence."""
    ways = ", ".join(f"{t}-way {100 * (r.value or 0):.0f} %" for t, r in covered.t_way if 2 <= t <= 3)
    return f"{covered.situations.short} flown, {covered.draws} with seeds; {ways}; {covered.realised.short} came true whole."


def baseline_line(pool: Pool) -> str:
    """What the unmutated drone itself violates, in a sentence."""
    pairs = [pair for pair in pool.pairs.values() if pair.kind is Kind.SAFETY]
    if not any(pair.state is not State.UNKNOWN for pair in pairs):
        red = sum(pair.violated > 0 for pair in pairs)
        return f"violates a safety requirement in {red} of {len(pairs)} pairs of situation and requirement; no pool."
    found = []
    for name in pool.requirements(Kind.SAFETY):
        states = Counter(pair.state for pair in pairs if pair.requirement == name)
        ill = [f"{states[s]} {s.value}" for s in (State.RED, State.UNSTEADY, State.OPEN, State.VACUOUS) if states[s]]
        found.append(f"{name} steady in {states[State.STEADY]}" + (f" ({', '.join(ill)})" if ill else ""))
    return f"{'; '.join(found)} situations with a pool.  Red: `scaloft-fi score --all`."


def _told(scored: Score) -> tuple[MutantScore, ...]:
    return (*scored.mutants, *scored.controls)


def _groups(scored: Score) -> dict[str, list[MutantScore]]:
    flown = [mutant for mutant in scored.mutants if mutant.flown]
    groups = {verdict.words.capitalize(): [m for m in flown if m.verdict is verdict] for verdict in Verdict}
    groups["Detected"].sort(key=lambda mutant: -len(mutant.killing))
    groups["The harness failed"] = [mutant for mutant in scored.mutants if not mutant.flown]
    return groups | {"Controls (in no ratio)": list(scored.controls)}


def _group(title: str, listed: Sequence[MutantScore], rows: Mapping[str, tuple[str, ...]], whole: bool) -> Table:
    shown = listed if whole or len(rows) <= MANY else listed[:SHOWN]
    notes = (f"... and {len(listed) - len(shown)} more: `scaloft-fi score --all`",) if len(shown) < len(listed) else ()
    kept = tuple(rows[mutant.subject.id] for mutant in shown)
    return Table(f"{title}: {len(listed)}", HEADERS, kept, notes)


def _row(mutant: MutantScore, space: Space, background: Background | None) -> tuple[str, ...]:
    return (
        mutant.subject.id,
        f"{len(mutant.killing)}/{mutant.kill_rate.whole}",
        _by(mutant),
        mutant.condition(space),
        f"{mutant.first.t_s:.1f}" if mutant.first else "",
        effect(mutant),
        _next(mutant, background),
    )


def _by(mutant: MutantScore) -> str:
    if mutant.requirements:
        return ", ".join(f"{name} {ratio.short}" for name, ratio in mutant.requirements)
    by = [*mutant.safety.by, *mutant.operability.by]
    seen = Counter(name for result in mutant.results for name in result.seen)
    return ", ".join(by) or ", ".join(f"{name} seen {count}x" for name, count in seen.items())


def effect(mutant: MutantScore) -> str:
    """What the fault does to the flight, in words."""
    struck = list(dict.fromkeys(kill.first.struck for kill in mutant.kills if kill.first.struck))
    if not struck and mutant.first is not None and mutant.first.struck:
        struck = [mutant.first.struck]
    said = [f"strikes {', '.join(struck)}"] if struck else []
    if mutant.detected and not struck:
        said.append("no contact")
    if mutant.operability.detected:
        said.append(f"breaks {', '.join(mutant.operability.by)}")
    if not said and not mutant.tested and mutant.infected:
        return "acts only where no pair is steady"
    return "; ".join(said) or _STOPPED[mutant.status]


def _next(mutant: MutantScore, background: Background | None) -> str:
    laddered = background is not None and background.laddered
    if mutant.detected:
        return f"margin {cell_of(mutant.subject.id)}" if laddered else ""
    if mutant.verdict is Verdict.UNDECIDED:
        if mutant.safety.needed is None:
            return "a pool" if not mutant.tested else "more than 50 seeds"
        anew = " --campaign NEW" * mutant.safety.anew
        return f"run{anew} --seeds {mutant.safety.needed}"
    if background is not None and background.expected and not mutant.infected:
        return "expected"
    if mutant.verdict is Verdict.NOT_DETECTED and background is not None and background.stronger:
        return f"run {background.stronger[0]}"
    return "another situation" if mutant.verdict is Verdict.NOT_TESTED else "kills"
