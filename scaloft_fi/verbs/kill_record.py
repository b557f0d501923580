"""The kill matrix and what follows from it, as plain JSON values: what `kills` prints for programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scaloft_fi.analysis.kill_matrix import NOT_FLOWN, KillMatrix
from scaloft_fi.analysis.roster import by_field, plain
from scaloft_fi.analysis.suite import Orders, Redundancy, Subsumption
from scaloft_fi.judge.status import Status
from scaloft_fi.verbs.score_record import FIRM, SEVERITY, VERDICTS
from scaloft_fi.verbs.snapshot import STALE
from scaloft_fi.verbs.survivors import Stage
from scaloft_fi.verbs.verdict import Next
from scaloft_fi.views.output import Output, by_name, count, flag, listing, number, optional, ratio, record, text, texts

_MUTANT = text("id of the mutant")
_STATES = [*(status.value for status in Status), NOT_FLOWN]
_NOT_ASKED = "not asked for"
KILLS = Output(
    "kills",
    "1.1",
    "where mutants are killed, which situations are needed, and what would change the rest",
    {
        "values": listing(
            "the values of the axes",
            record(
                "a value",
                {"axis": text("id of the axis"), "value": text("as in keys"), "word": text("its short name")},
            ),
        ),
        "mutants": listing(
            "the mutants asked for, then controls and PLACEBO",
            record(
                "a mutant",
                {
                    "id": text("canonical id"),
                    "guideword": text("its guideword; of PLACEBO empty"),
                    "parameter": text("its parameter; of PLACEBO empty"),
                    "magnitude": text("its magnitude with the unit, as in the id; empty where there is none"),
                    "kind": text("what it is", ["mutant", "control", "placebo"]),
                    "counted": flag("whether the ratios count it: the default of a credible cell"),
                    "status": text("the furthest stage that a flight reached", [status.value for status in Status]),
                    "verdict": text("on the mutant", VERDICTS),
                    "firm": FIRM,
                    "kill_rate": ratio("situations with a kill, of those that put it to the test"),
                },
            ),
        ),
        "results": listing(
            "each of them in each situation of the grid; of a large grid in those flown",
            record(
                "a mutant in a situation",
                {
                    "mutant": _MUTANT,
                    "situation": text("key of the situation"),
                    "state": text("the furthest stage that a flight reached", _STATES),
                    "kills": texts("requirements that kill it here"),
                    "seen": texts("safety requirements that test it here and that a flight violates"),
                    "tested": flag("whether a safety requirement puts it to the test here"),
                    "flown": count("flights that count"),
                    "infected": flag("whether it changed a sample in any"),
                    "violated": by_name("by requirement that any flight violates", count("flights that violate it")),
                },
            ),
        ),
        "detected_without_kill": texts("ids of detected mutants of which most flights violate in no situation"),
        "chosen": optional(
            record(
                "what the situations of --situation kill together",
                {
                    "situations": texts("their keys"),
                    "killed": ratio("mutants killed there, of those that are killed anywhere"),
                    "dominator_score": ratio("minimal mutants killed there, of all minimal mutants"),
                    "lost": texts("ids of mutants that are killed elsewhere only"),
                },
            ),
            _NOT_ASKED,
        ),
        "conditions": optional(
            listing(
                "how the kills of each mutant depend on the axes",
                record(
                    "a mutant",
                    {
                        "mutant": _MUTANT,
                        "counted": flag("whether the ratios count it"),
                        "condition": text("the shortest condition: `human & light`"),
                        "order": count("fewest axes that have to be right"),
                        "order_at_most": count("the same if it survived where nothing is known"),
                        "killing": count("situations where it is killed"),
                        "unknown": count("situations that say nothing"),
                    },
                ),
            ),
            _NOT_ASKED,
        ),
        "orders": optional(
            listing(
                "mutants by how many axes have to be right",
                record(
                    "an order",
                    {
                        "order": count("number of axes"),
                        "mutants": count("killed mutants of this order"),
                        "mutants_at_most": count("the same where nothing unknown helps"),
                        "cumulative_percent": optional(
                            number("share of the killed mutants with at most this order", "%"), "none was killed"
                        ),
                    },
                ),
            ),
            _NOT_ASKED,
        ),
        "situations": optional(
            listing(
                "each situation flown, as a test",
                record(
                    "a situation",
                    {
                        "situation": text("its key"),
                        "killed": texts("ids of the mutants killed there"),
                        "tested": count("mutants that it puts to the test"),
                        "alone": texts("ids of those killed in no other situation"),
                        "minimal": ratio("minimal mutants killed there, of all"),
                    },
                ),
            ),
            _NOT_ASKED,
        ),
        "suite": optional(
            record(
                "the fewest situations that together kill every mutant that any situation kills",
                {
                    "situations": texts("their keys"),
                    "exact": flag("whether no smaller set does"),
                    "alternatives": optional(count("sets of this size that do"), "not exact, or too many to count"),
                    "needed": texts("keys of situations in every such set"),
                },
            ),
            _NOT_ASKED,
        ),
        "subsumption": optional(
            record(
                "which kills imply which",
                {
                    "nodes": listing(
                        "mutants with the same kills",
                        record(
                            "a node",
                            {
                                "node": count("its number, from 0"),
                                "mutants": texts("ids"),
                                "kills": texts("what kills them: keys, with --by-requirement key and requirement"),
                                "layer": count("its distance from what no other subsumes"),
                                "minimal": flag("whether no other subsumes it"),
                            },
                        ),
                    ),
                    "edges": listing(
                        "what kills one also kills the other",
                        record(
                            "an edge", {"subsuming": count("number of a node"), "subsumed": count("number of a node")}
                        ),
                    ),
                    "killed": count("mutants in the graph"),
                    "distinct": count("nodes"),
                    "minimal": count("nodes that no other subsumes"),
                },
            ),
            _NOT_ASKED,
        ),
        "redundancies": optional(
            listing(
                "cells with two or more killed mutants",
                record(
                    "a cell",
                    {
                        "cell": text("its name"),
                        "killed": count("its mutants that are killed"),
                        "duplicates": listing("groups of them with the same kills", texts("ids")),
                        "redundant": ratio("mutants that could be left out, of those killed"),
                    },
                ),
            ),
            _NOT_ASKED,
        ),
        "survivors": optional(
            listing(
                "the mutants that are not detected, those of the worst class of severity first",
                record(
                    "a mutant",
                    {
                        "mutant": _MUTANT,
                        "verdict": text("on the mutant", VERDICTS),
                        "stage": text("where it stopped", [stage.value for stage in Stage]),
                        "next": text("what to change", [one.value for one in Next]),
                        "why": text("the facts, and what to do, in a few sentences"),
                        "loss": optional(
                            record(
                                "where it took most of a baseline's margin in a steady pair",
                                {
                                    "requirement": text("name of the requirement"),
                                    "situation": text("key of the situation"),
                                    "seed": count("seed of the flight"),
                                    "baseline": number("robustness of the baseline, in the requirement's unit"),
                                    "flown": number("robustness of the flight, in the requirement's unit"),
                                    "share": number("share of the margin that it took; below 0 it gained some"),
                                },
                            ),
                            "it cannot be measured",
                        ),
                        "off_path_m": optional(
                            number("how far it was off its baseline's path at the most", "m"),
                            "no flight that put it to the test has a trajectory",
                        ),
                        "find": text("name of the find that is to be flown; empty without one"),
                        "severity": SEVERITY,
                    },
                ),
            ),
            _NOT_ASKED,
        ),
        **STALE,
    },
    rows="mutants",
)


def kill_values(matrix: KillMatrix, results: Mapping[str, Any]) -> dict[str, Any]:
    """Plain JSON values of the form `KILLS`.

    Args:
        matrix: the rows asked for.
        results: what was asked for besides, by name.
    """
    told = {name: plain(value) for name, value in results.items()}
    for name, make in (("orders", _orders), ("subsumption", _subsumption), ("redundancies", _redundancies)):
        if name in results:
            told[name] = make(results[name])
    space = matrix.space
    return {
        **dict.fromkeys(KILLS.keys),
        "values": [
            {"axis": axis, "value": value, "word": word}
            for axis, values, words in zip(space.axes, space.values, space.words, strict=True)
            for value, word in zip(values, words, strict=True)
        ],
        "mutants": [
            {
                "id": row.id,
                "guideword": row.subject.guideword,
                "parameter": row.subject.parameter,
                "magnitude": row.subject.magnitude,
                "kind": row.kind,
                "counted": row.counted,
                "status": row.status.value,
                "verdict": row.verdict.value,
                "firm": row.firmness.value if row.firmness else None,
                "kill_rate": plain(row.kill_rate),
            }
            for row in matrix.rows
        ],
        "results": [
            {"mutant": row.id, **plain(entry), "violated": dict(entry.violated)}
            for row in matrix.rows
            for entry in row.entries
        ],
        "detected_without_kill": list(matrix.scattered),
        **told,
    }


def _orders(orders: Orders) -> list[Mapping[str, Any]]:
    counted = zip(orders.counts, orders.counts_at_most, orders.cumulative(), strict=True)
    return [
        {"order": order, "mutants": mutants, "mutants_at_most": most, "cumulative_percent": share}
        for order, (mutants, most, share) in enumerate(counted)
    ]


def _subsumption(graph: Subsumption) -> dict[str, Any]:
    told = graph.to_json()
    nodes = [{"node": number, **node} for number, node in enumerate(told["nodes"])]
    edges = [{"subsuming": above, "subsumed": below} for above, below in graph.edges]
    return told | {"nodes": nodes, "edges": edges}


def _redundancies(found: tuple[Redundancy, ...]) -> list[dict[str, Any]]:
    return [by_field(one) | {"redundant": plain(one.redundant)} for one in found]
