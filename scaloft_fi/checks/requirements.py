"""The requirements of a study, formula by formula, against the signals and what they can read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Findings
from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.bounds import ANY, Ranges, Spans, bounds_of, constants, verdict, within_caps
from scaloft_fi.judge.requirement import MOST, TRIGGER, Check, Kind, Requirement, read_definition, read_requirement
from scaloft_fi.judge.stl import Formula, inside_always, tokenize

if TYPE_CHECKING:
    from collections.abc import Collection


@dataclass(frozen=True)
class KnownSignals:
    """The signals of a study.

    Attributes:
        ranges: what each can read, by name.
        caps: the cap of each belief and optional signal that has one.
    """

    ranges: Ranges
    caps: Mapping[str, float] = field(default_factory=dict)

    @property
    def check(self) -> Check:
        """The check of a formula: thresholds within caps, and the grammar."""
        return within_caps(Formula.parse, self.caps)


def kinds_in(path: Path) -> Mapping[str, str]:
    """The kind of each requirement by name, as it stands in the file; empty for a file that cannot be read so far."""
    try:
        entries = load(path).need("requirements").mapping()
        return {name: str(kind.value) if (kind := item.get("kind")) else "" for name, item in entries.items()}
    except InputError:
        return {}


def check_requirements(path: Path, known: KnownSignals, findings: Findings) -> int:
    """Read every definition and requirement; returns how many requirements there are.

    Args:
        path: `sim/requirements.yaml`.
        known: the signals.
        findings: takes the findings.
    """
    read: list[Requirement] = []
    entries: Mapping[str, Item] = {}
    with findings.collecting():
        document = load(path)
        definitions = document.get("definitions")
        ranges, texts = dict(known.ranges), dict[str, str]()
        for name, item in (definitions.mapping(most=MOST) if definitions else {}).items():
            with findings.collecting():
                texts[name] = read_definition(name, item, set(ranges), known.check)
                _tell_constants(texts[name], ranges, item, f"definition {name!r}", findings)
                ranges[name] = bounds_of(Formula.parse(texts[name], set(ranges)), ranges)
            ranges.setdefault(name, ANY)  # its name is known, whatever it says
            texts.setdefault(name, str(item.value))
        entries = document.need("requirements").mapping(most=MOST)
        for name, item in entries.items():
            with findings.collecting():
                read.append(read_requirement(name, item, texts, set(ranges), known.check))
                _check_bounds(read[-1], item, ranges, findings)
        document.close()
        if len(read) == len(entries) and not any(one.kind is Kind.SAFETY for one in read):
            what = "no requirement is of kind safety, so no mutant can be detected"
            findings.wrong(document.need("requirements").place, what, "give one of them `kind: safety`")
    return len(entries)


def _check_bounds(requirement: Requirement, item: Item, ranges: Mapping[str, Spans], findings: Findings) -> None:
    known = dict(ranges)
    trigger = item.get("trigger")
    if trigger is not None:
        formula = Formula.parse(requirement.trigger, set(known))
        known[TRIGGER] = bounds_of(formula, known)
        always = verdict(known[TRIGGER])
        if always is False:
            what = f"the trigger of {requirement.name} comes true in no flight, so the requirement is vacuous in all"
            findings.wrong(trigger.place, what, _reads(formula, known))
            return
        if always:
            what = f"the trigger of {requirement.name} is true at every sample of every flight"
            findings.note(trigger.place, what, "leave it out, or mend it")
        else:
            _tell_constants(requirement.trigger, known, trigger, f"trigger of {requirement.name}", findings)
    body = inside_always(requirement.text)
    assert body is not None
    formula = Formula.parse(body, set(known))
    always = verdict(bounds_of(formula, known))
    place = item.need("formula")
    if always is not None:
        what = f"{requirement.name} is {'held' if always else 'violated'} by every flight, whatever the drone does"
        findings.wrong(place.place, what, _reads(formula, known))
    else:
        _tell_constants(body, known, place, f"formula of {requirement.name}", findings)


def check_predicate(
    text: str, place: str, name: str, known: KnownSignals, passing: Collection[str], findings: Findings
) -> None:
    """Check the formula `realised` of a value.

    Args:
        text: the formula.
        place: where it stands.
        name: name of the value.
        known: the signals that every flight records.
        passing: names of the signals that only some flights record.
        findings: takes the findings.

    Raises:
        FormulaError: it is no formula over the signals, or compares one beyond its cap.
    """
    ranges = {**dict.fromkeys(passing, ANY), **known.ranges}
    formula = known.check(text, set(ranges))
    always = verdict(bounds_of(formula, ranges))
    if always is not None:
        what = f"realised of {name} comes true in {'every' if always else 'no'} flight: {text}"
        findings.wrong(place, what, _reads(formula, ranges))
    else:
        for comparison, true in constants(formula, ranges):
            _tell(comparison, place, f"realised of {name}", formula, ranges, findings, true=true)


def _tell_constants(text: str, ranges: Ranges, item: Item, about: str, findings: Findings) -> None:
    formula = Formula.parse(text, set(ranges))
    for comparison, true in constants(formula, ranges):
        _tell(comparison, item.place, about, formula, ranges, findings, true=true)


def _tell(
    comparison: str, place: str, about: str, formula: Formula, ranges: Ranges, findings: Findings, *, true: bool
) -> None:
    what = f"'{comparison}' in the {about} is {str(true).lower()} at every sample of every flight"
    findings.note(place, what, _reads(formula, ranges, tokenize(comparison)))


def _reads(formula: Formula, ranges: Mapping[str, Spans], words: Collection[str] = ()) -> str:
    """What the signals of a formula can read, as advice."""
    names = [name for name in formula.names if not words or name in " ".join(words)]
    spans = [f"{name} {' or '.join(_span(*span) for span in ranges[name])}" for name in names if name in ranges]
    return f"compare with what can be measured: {', '.join(spans)}"


def _span(low: float, high: float) -> str:
    return f"is {low:g}" if low == high else f"is {low:g} to {high:g}".replace("-inf to inf", "any number")
