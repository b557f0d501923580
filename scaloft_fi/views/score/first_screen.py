"""The first screen after `run` and `score`: four answers, the mutants by verdict, coverage, what the drone does.

Long groups are cut unless everything is asked for; the other tables stand behind `--all`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from scaloft_fi.analysis.coverage import Coverage
from scaloft_fi.analysis.detection import Firmness, Noise, Verdict
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Accepted, Background
from scaloft_fi.console import PROSE, Marked, Style, coloured, line, styled, wrapped
from scaloft_fi.console import width as terminal_width
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import class_of, worst_first
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.score.accepted import accepted_line
from scaloft_fi.views.score.answers import Line, answers
from scaloft_fi.views.score.next_step import SHORT, Next, next_steps, short_step
from scaloft_fi.views.score.noise import noise_line
from scaloft_fi.views.tables.meaning import commands
from scaloft_fi.views.tables.table import Format, Table, render

MANY, SHOWN = 12, 10
"""Of a group of more mutants than `MANY` the first `SHOWN` are shown."""
WIDEST = 24
"""Longest condition that a row shows."""
TITLE = "Would your tests have shown it?"
COLUMNS = {
    Verdict.DETECTED: ("killed in", "firm", "by", "where", "first", "effect"),
    Verdict.UNDECIDED: ("seen", "where", "first", "effect", "next"),
    Verdict.NOT_DETECTED: ("tested in", "effect", "next"),
    Verdict.NOT_TESTED: ("effect", "next"),
}
"""The columns of each group of mutants."""
SEVERITY = "severity"
"""Column of the groups of survivors in a study with classes; the worst class stands first."""
SPARE = ("where", "by", "seen", "first")
"""The columns that a narrow terminal does without, in the order in which they are left out."""
CONTROL_COLUMNS = ("shows itself by", "effect")
LEGEND = (
    (
        "killed in: situations where most flights of a detected fault violate a requirement, of those that test it "
        "(it changes samples, nine in ten unmutated flights hold).  no kill: violated here and there."
    ),
    "firm: detected whichever one seed is left out; pool: of the baseline's alone.  by: per requirement.",
    "where: `mixed`: see `scaloft-fi kills ID`.  first: earliest such violation [s from take-off].",
    "next: seeds that decide (`run --mutant ID --seeds N`; anew: its own campaign); detected: `margin`.",
)
NO_KILL = "no kill"
"""Of a detected mutant without a situation where most of its flights violate."""
WITH_FIND = (
    *LEGEND[:-1],
    "next: `run --mutant ID --seeds N` (anew: its own campaign); find: `kills ID --show survivors`.",
)
"""The legend where a row tells of a find."""
NAMES_BESIDE = 70
"""A narrower terminal has the name of an answer above it, not beside it [characters]."""
FIRM = {
    Firmness.FIRM: "yes",
    Firmness.FIRM_BY_POOL: "pool",
    Firmness.HANGS: "no",
    Firmness.TOO_FEW: "too few seeds",
}
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
    background: Callable[[str], Background | None],
    *,
    campaign: str = CAMPAIGN,
    finds: KnownFinds = NO_FINDS,
    noise: Sequence[Noise] = (),
    accepted: Sequence[Accepted] = (),
    whole: bool = False,
) -> tuple[Table, ...]:
    """The screen as tables: the answers, a table a group, and the two lines.

    Args:
        scored: the campaign's score.
        roster: which mutants count.
        space: the grid.
        covered: its situation coverage.
        background: of the mutant with an id; None where nothing is known of it.
        campaign: its name, for the commands.
        finds: of the study.
        noise: of a stack that is not deterministic.
        accepted: the survivors that somebody accepted.
        whole: whether groups are shown to their ends.
    """
    replies = answers(scored, roster, campaign, finds, space.grid)
    lines = [Line("Situations", coverage_line(covered)), Line("Unmutated drone", baseline_line(scored.pool))]
    if accepted:
        lines.append(Line("Accepted", accepted_line(scored, accepted)))
    if noise:
        lines.append(Line("Noise", noise_line(noise)))
    counted = Counter(mutant.verdict for mutant in scored.counted)
    groups = []
    for verdict in Verdict:
        members = [mutant for mutant in scored.mutants if mutant.flown and mutant.verdict is verdict]
        if verdict is Verdict.DETECTED:
            members.sort(key=lambda mutant: -len(mutant.killing))
        else:
            members = worst_first(members, lambda mutant: mutant.severity)
        columns = COLUMNS[verdict]
        if verdict is not Verdict.DETECTED and any(mutant.severity for mutant in members):
            columns = (SEVERITY, *columns)
        shown = _shown(members, whole=whole)
        facts = [_facts(mutant, scored, space, background(mutant.subject.id), finds) for mutant in shown]
        rows = [(one["mutant"], *(one[column] for column in columns)) for one in facts]
        title = f"{verdict.words.capitalize()}: {len(members)}"
        if counted[verdict] != len(members):
            title += f", of which {counted[verdict]} count in the score"
        same = sum(mutant.without_effect for mutant in members) if verdict is Verdict.UNDECIDED else 0
        title += f"; {same} {'fly' if same > 1 else 'flies'} the same to the bit" if same else ""
        groups.append(_group(title, columns, rows, len(members)))
    controls = [_control(mutant) for mutant in _shown(scored.controls, whole=whole)]
    showing = sum(map(_shows, scored.controls))
    title = f"Controls, in no ratio: {showing} of {len(scored.controls)} show that faults reach the drone"
    groups.append(_group(title, CONTROL_COLUMNS, controls, len(scored.controls)))
    groups = [group for group in groups if group.rows]
    if groups:
        found = any(row[-1] == SHORT[Next.FIND] for group in groups for row in group.rows)
        groups[-1] = replace(groups[-1], notes=(*groups[-1].notes, "", *(WITH_FIND if found else LEGEND)))
    return (
        Table(TITLE, ("question", "answer"), tuple(replies)),
        *groups,
        Table("Besides", ("what", "finding"), tuple(lines)),
    )


def screen_text(screen: Sequence[Table], *, width: int | None = None, marked: bool | None = None) -> str:
    """The screen as a terminal shows it: answers and findings as lines, the groups as tables between them.

    Args:
        screen: of a score.
        width: of the terminal [characters]; that of standard output when None.
        marked: whether the text has colours; as standard output has them when None.
    """
    columns = terminal_width() if width is None else width
    colours = coloured() if marked is None else marked
    first, *groups, last = screen
    parts = [render([table], Format.TABLE, width=columns, marked=colours) for table in groups]
    text = "\n".join([_lines(first, columns, marked=colours), *parts, _lines(last, columns, marked=colours)])
    return Marked(text) if colours else text


def _lines(table: Table, width: int, *, marked: bool) -> str:
    """A table of two columns as lines: the first column is what the others are indented by."""
    wide = max(len(str(name)) for name, _ in table.rows) + 2
    lines = []
    for name, text in table.rows:
        head = styled(str(name), Style.STRONG) if marked else str(name)
        if width < NAMES_BESIDE:
            lines.append(f"{head}\n{_wrapped(str(text), width, 2, marked=marked)}\n")
        else:
            gap = " " * (wide - len(str(name)))
            lines.append(f"{head}{gap}{_wrapped(str(text), width, wide, marked=marked).lstrip()}\n")
    return "".join(lines)


def _wrapped(text: str, width: int, indent: int, *, marked: bool) -> str:
    blanks = " " * indent
    return commands(wrapped(line(text), min(width, PROSE), blanks, blanks), marked=marked)


def coverage_line(covered: Coverage) -> str:
    """The situations in a sentence."""
    ways = ", ".join(f"{t}-way {100 * (r.value or 0):.0f} %" for t, r in covered.t_way if 2 <= t <= 3 and r.whole)
    return f"{covered.situations.short} flown, {ways} covered; in {covered.realised.short} every value came true."


def baseline_line(pool: Pool) -> str:
    """What the unmutated drone itself violates, in a sentence."""
    pairs = [pair for pair in pool.pairs.values() if pair.kind is Kind.SAFETY]
    if not any(pair.state is not State.UNKNOWN for pair in pairs):
        red = sum(pair.violated > 0 for pair in pairs)
        return f"violates a safety requirement in {red} of {len(pairs)} pairs of situation and requirement; no pool."
    held = []
    for name in pool.requirements(Kind.SAFETY):
        states = Counter(pair.state for pair in pairs if pair.requirement == name and pair.state is not State.UNKNOWN)
        ill = [f"{states[s]} {s.value}" for s in (State.RED, State.UNSTEADY, State.OPEN, State.VACUOUS) if states[s]]
        held.append(f"{name} in {states[State.STEADY]}" + (f" ({', '.join(ill)})" if ill else ""))
    steadily = f"of {len(pool.flown)} situations with a pool it holds steadily {', '.join(held)}."
    return "  ".join([steadily, *mostly_red(pool)])


def mostly_red(pool: Pool) -> list[str]:
    """A sentence for each requirement that the unmutated drone violates in most situations, and what to do."""
    sentences = []
    for kind in (Kind.SAFETY, Kind.OPERABILITY):
        for name in pool.requirements(kind):
            states = Counter(state for (_, named), state in pool.states.items() if named == name)
            known = states.total() - states[State.UNKNOWN]
            if 2 * states[State.RED] > known:
                where = f"{states[State.RED]} of {known} situation{'s' * (known != 1)}"
                sentences.append(
                    f"{name} is red in {where}: most flights without a fault violate it, so it shows no fault "
                    f"there.  Mend the drone or {name}; `scaloft-fi score --all` names the situations."
                )
    return sentences


def _shown(members: Sequence[MutantScore], *, whole: bool) -> Sequence[MutantScore]:
    return members if whole or len(members) <= MANY else members[:SHOWN]


def _group(title: str, columns: Sequence[str], rows: Sequence[tuple[str, ...]], members: int) -> Table:
    """A group's table; its note counts the members that are not shown."""
    notes = (f"... and {members - len(rows)} more: `scaloft-fi score --all`",) if len(rows) < members else ()
    return Table(title, ("mutant", *columns), tuple(rows), notes, tuple(each for each in SPARE if each in columns))


def _facts(
    mutant: MutantScore, scored: Score, space: Space, background: Background | None, finds: KnownFinds
) -> dict[str, str]:
    where = mutant.condition(space)
    seen = Counter(name for result in mutant.results for name in result.seen)
    return {
        "mutant": mutant.subject.id,
        SEVERITY: class_of(mutant.severity),
        "killed in": mutant.kill_rate.short if mutant.kills else NO_KILL,
        "firm": FIRM[mutant.firmness] if mutant.firmness else "",
        "by": ", ".join(f"{name} {ratio.short}" for name, ratio in mutant.requirements if name in mutant.safety.p)
        or ", ".join(mutant.safety.by),
        "seen": ", ".join(f"{name} in {count}/{mutant.kill_rate.whole}" for name, count in seen.items()),
        "tested in": str(mutant.kill_rate.whole),
        "where": where if len(where) <= WIDEST else "mixed",
        "first": f"{mutant.first.t_s:.1f}" if mutant.first else "",
        "effect": effect(mutant),
        "next": short_step(mutant, next_steps(mutant, scored, background, finds), background),
    }


def _control(mutant: MutantScore) -> tuple[str, ...]:
    by = ", ".join((*mutant.safety.by, *mutant.operability.by)) or (_violated(mutant) if _shows(mutant) else "nothing")
    return mutant.subject.id, by, _broken(mutant) or _STOPPED[mutant.status]


def _shows(mutant: MutantScore) -> bool:
    """Whether a control shows that faults reach the drone: by a verdict, or by one flight beside its own baseline."""
    return mutant.detected or mutant.operability.detected or mutant.status is Status.REVEALED


def _violated(mutant: MutantScore) -> str:
    """What a control violates that was flown too seldom for a verdict, as a canary is."""
    flights = Counter(name for result in mutant.results for name, count in result.violated for _ in range(count))
    return ", ".join(f"{name} in {count} flight{'s' * (count > 1)}" for name, count in flights.items())


def effect(mutant: MutantScore) -> str:
    """What the fault does to the flight, in words."""
    if broken := _broken(mutant):
        return broken
    if mutant.infected and not mutant.tested:
        unknown = mutant.verdict is Verdict.UNDECIDED
        return "no baseline pool where it acts" if unknown else "acts only where no pair is steady"
    return _STOPPED[mutant.status]


def _broken(mutant: MutantScore) -> str:
    """What the fault breaks, as far as the verdict knows; empty where it breaks nothing."""
    struck = list(dict.fromkeys(kill.first.struck for kill in mutant.kills if kill.first.struck))
    if not struck and mutant.first is not None and mutant.first.struck:
        struck = [mutant.first.struck]
    if struck:
        return f"strikes {struck[0]}" + f" +{len(struck) - 1}" * (len(struck) > 1)
    if mutant.detected:
        return "no contact"
    return f"breaks {', '.join(mutant.operability.by)}" if mutant.operability.detected else ""
