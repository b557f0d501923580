"""What a search found, as plain JSON values."""

from __future__ import annotations

from typing import Any

from scaloft_fi.analysis.roster import by_field, plain
from scaloft_fi.campaign.seeking.breaks import BreaksReport
from scaloft_fi.campaign.seeking.finds import ReplicationReport
from scaloft_fi.campaign.seeking.seek import SeekReport
from scaloft_fi.sim.found import Break, Find
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, flag, listing, number, optional, record, text, texts

_NAMED = {
    "name": text("name of the situation, as sim/found.yaml has it"),
    "situation": text("its key in the grid of the search"),
    "words": texts("its values that are not benign, in words"),
}
_ROBUST = "in the requirement's unit"
_AGAIN = record(
    "the evidence of a replication, from seeds that nothing before used",
    {
        "seed": count("the first seed"),
        "p": number("p of the requirement by the exact test, adjusted by Holm over the pairs replicated together"),
        "violated": count("flights of the mutant that violate the requirement"),
        "flights": count("flights of the mutant"),
        "held": count("baselines that hold the requirement by more than their spread"),
        "baselines": count("baselines"),
        "mission": count("baselines that hold every operability requirement and meet every axis value"),
    },
)
SEEK = Output(
    "seek",
    "1.1",
    "the situations that a search found: those that show mutants, or those that break the unmutated drone",
    {
        "finds": listing(
            "the situations that show mutants, in the order of finding",
            record(
                "a find",
                {
                    **_NAMED,
                    "mutant": text("id of the mutant that it was found for"),
                    "seed": count("seed of the search"),
                    "shows": listing(
                        "each mutant that it shows, with the evidence from fresh seeds",
                        record(
                            "a mutant",
                            {
                                "mutant": text("id of the mutant"),
                                "requirement": text("the requirement that it violates"),
                                "candidate": count("which candidate of the mutant the situation was, from 1"),
                                "p": number("p of the score's own test (0..1)"),
                                "alpha": number("what p was compared with (0..1)"),
                                "violated": count("its flights that violate the requirement"),
                                "flights": count("its flights"),
                                "struck": text("the body that the first of them strikes; empty for none"),
                                "held": count("baselines that hold the requirement by more than their spread"),
                                "baselines": count("baselines"),
                                "margin": number(f"robustness that nine in ten baselines reach, {_ROBUST}"),
                                "spread": number(f"standard deviation of robustness over the baselines, {_ROBUST}"),
                                "mission": count(
                                    "baselines that hold every operability requirement and meet every axis value"
                                ),
                                "again": optional(_AGAIN, "not replicated"),
                            },
                        ),
                    ),
                },
            ),
        ),
        "sought": listing(
            "the mutants that were sought; of `seek baseline` empty",
            record(
                "a mutant",
                {
                    "mutant": text("id of the mutant"),
                    "shown_in": text("key of the situation that shows it; empty where none was found"),
                    "after": count("flights of the search when it was found; 0 where it was not"),
                    "candidates": count("situations that were tested on fresh seeds"),
                    "spent": number("what they spent of alpha (0..1)"),
                    "effort": record(
                        "how far the search came, in flights with its first seed",
                        {
                            "situations": count("flown, where the baseline does its mission and holds with room"),
                            "reached": count("of these, where the seam carried a sample"),
                            "infected": count("of these, where the mutant changed one"),
                            "diverged": count("of these, where the drone then flew otherwise than the baseline"),
                            "showed": count("of these, where it violates what the baseline holds with room"),
                            "nearest": number("the least share of the baseline's robustness that it kept"),
                            "requirement": text("of which requirement; empty where no sample was changed"),
                            "situation": text("key of the situation where; empty where no sample was changed"),
                        },
                    ),
                },
            ),
        ),
        "breaks": listing(
            "of `seek baseline`: the situations that break the unmutated drone, in the order of finding",
            record(
                "a break",
                {
                    **_NAMED,
                    "requirement": text("the requirement that is violated"),
                    "struck": text("the body that is struck; empty for none"),
                    "leg": text("where on the route: `corner to end`"),
                    "near": text("the body that is struck, or the nearer end of the leg"),
                    "belief": text("the stage whose belief was the most wrong before; empty where none was wrong"),
                    "error": number("how far from the truth that belief was, in `unit`"),
                    "unit": text("unit of the error"),
                    "violated": count("flights that violate the requirement"),
                    "flights": count("flights with fresh seeds"),
                    "alike": count("flights that do so in the same way"),
                    "flight": count("seed of the flight that is told of"),
                    "t_s": number("time of its violation", "s from take-off"),
                    "place": listing("x, y, z of the vehicle then", number("coordinate", "m, world")),
                    "seed": count("seed of the search"),
                },
            ),
        ),
        "replicas": listing(
            "of `seek --replicate`: the pairs of find and mutant that were flown again",
            record(
                "a pair",
                {
                    "find": text("name of the find"),
                    "mutant": text("id of the mutant"),
                    "requirement": text("the requirement that it is to violate"),
                    "holds": flag("whether the find holds for the mutant; else it left sim/found.yaml"),
                    "why": text("why it does not; empty where it does"),
                    "again": _AGAIN,
                },
            ),
        ),
        "first": optional(count("of `seek --replicate`: the first seed"), "a search"),
        "situations": optional(count("of `seek baseline`: situations flown"), "mutants were sought"),
        "broken": optional(
            count("of these situations, where the drone violates with the first seed"), "mutants were sought"
        ),
        "candidates": optional(
            count("of `seek baseline`: violations that were tested on fresh seeds"), "mutants were sought"
        ),
        "again": optional(
            count("of `seek baseline`: flights flown again to see what the drone believed"), "mutants were sought"
        ),
        "used": count("flights of the search, stored ones included"),
        "flown": count("flights that this run flew"),
        "spent": flag("whether the budget ended the search"),
        "alpha": optional(number("the study's, which the candidates of a mutant share"), "of `seek baseline`"),
        "anyhow": flag("whether situations counted where the unmutated drone does not do its mission"),
    },
    rows="finds",
)


_NONE: dict[str, Any] = {
    **{name: [] for name in ("finds", "sought", "breaks", "replicas")},
    **dict.fromkeys(("first", "situations", "broken", "candidates", "again", "alpha")),
    "spent": False,
    "anyhow": True,
}
"""What an answer has of the others."""


def seek_values(report: SeekReport) -> dict[str, Any]:
    """Plain JSON values of the form `SEEK`."""
    return _NONE | by_field(report) | {"finds": [_find(find) for find in report.finds]}


def breaks_values(report: BreaksReport) -> dict[str, Any]:
    """Plain JSON values of the form `SEEK` for `seek baseline`."""
    return _NONE | by_field(report) | {"breaks": [_break(one) for one in report.breaks]}


def replica_values(report: ReplicationReport) -> dict[str, Any]:
    """Plain JSON values of the form `SEEK` for `seek --replicate`."""
    return _NONE | by_field(report) | {"replicas": [plain(one) for one in report.replicas]}


def _find(find: Find) -> dict[str, Any]:
    return by_field(find) | {"shows": [{"mutant": mutant, **plain(told)} for mutant, told in find.shows.items()]}


def _break(one: Break) -> dict[str, Any]:
    return by_field(one)
