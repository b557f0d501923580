"""The score again, from the rows of `export` alone: plain Python that shares no code with what it checks.

Statuses are judged anew from each flight's facts, so that an error of `status` shows as well.
"""

from __future__ import annotations

import csv
import io
from fractions import Fraction
from itertools import combinations
from math import comb
from typing import Any

Row = dict[str, Any]
LADDER = ["invalid", "not_reached", "not_infected", "masked", "baseline_red", "survived", "revealed"]
SHARES = ("0.5", "0.75", "1")
LOOKS = (1, 3, 5, 10)


def read(text: str) -> list[Row]:
    rows: list[Row] = []
    for cells in csv.DictReader(io.StringIO(text)):
        row: Row = dict(cells)
        for name in ("violated", "held", "revealed_by", "triggered", "realised", "violation_times_s"):
            row[name] = [part for part in cells[name].split(";") if part]
        bodies = cells["violation_bodies"].split(";") if row["violated"] else []
        times = map(float, row["violation_times_s"])
        row["at"] = dict(zip(row["violated"], zip(times, bodies, strict=True), strict=True))
        row |= {name: int(cells[name]) for name in ("seed", "carried", "altered")}
        row["duration_s"] = float(cells["duration_s"])
        row["counts"] = cells["ending"] != ""
        rows.append(row)
    return rows


def revealing(row: Row, base: Row, kinds: dict[str, str], kind: str) -> list[str]:
    found = []
    for name, (t_s, body) in ((name, seen) for name, seen in row["at"].items() if kinds[name] == kind):
        if name in base["at"]:
            base_t_s, base_body = base["at"][name]
            told = body != base_body and t_s < base_t_s
        else:
            told = name in base["held"] or t_s <= base["duration_s"]
        if told:
            found.append((t_s, name))
    return [name for _, name in sorted(found, key=lambda pair: pair[0])]


def status(row: Row, base: Row | None, kinds: dict[str, str]) -> tuple[str, list[str]]:
    """The status of a flight, and the requirements by which it is told from its baseline."""
    if base is None or not row["counts"] or not base["counts"]:
        return "invalid", []
    if row["altered"] == 0:
        return "not_infected" if row["carried"] else "not_reached", []
    if row["digest"] == base["digest"]:
        return "masked", []
    safety, operability = (revealing(row, base, kinds, kind) for kind in ("safety", "operability"))
    red = any(kinds[name] == "safety" for name in row["violated"])
    return "revealed" if safety else "baseline_red" if red else "survived", safety + operability


def share(part: int, whole: int) -> Row:
    return {"part": part, "whole": whole}


def pairs(pool: list[Row], kinds: dict[str, str]) -> list[Row]:
    """What the baseline flights say of each requirement in each situation, in the order of the rows."""
    found = []
    for key in dict.fromkeys(row["situation"] for row in pool if row["counts"]):
        rows = [row for row in pool if row["situation"] == key and row["counts"]]
        for name, kind in kinds.items():
            if kind == "reported":
                continue
            red = sum(name in row["violated"] for row in rows)
            held = sum(name in row["held"] for row in rows)
            triggered = sum(name in row["violated"] or name in row["triggered"] for row in rows)
            if len(rows) < 10:
                state = "unknown"
            elif triggered < Fraction(len(rows), 2):
                state = "vacuous"
            elif len(rows) - red - held > Fraction(len(rows), 10):
                state = "open"
            elif held >= Fraction(9 * len(rows), 10):
                state = "steady"
            else:
                state = "red" if red > Fraction(len(rows), 2) else "unsteady"
            entry = {"situation": key, "requirement": name, "kind": kind, "violated": red, "flights": len(rows)}
            found.append(entry | {"open": len(rows) - red - held, "triggered": triggered, "state": state})
    return found


def state(table: dict[tuple[str, str], Row], key: str, name: str) -> str:
    """Of a pair; unknown where it has no flights."""
    return str(table[key, name]["state"]) if (key, name) in table else "unknown"


def exact(strata: list[tuple[int, int, int, int, int]]) -> Fraction:
    """The stratified test in whole numbers; last in a stratum: the size of the whole pool, which sets the gate."""
    observed, sums, ways = 0, {0: 1}, 1
    for k, n, b, m, whole in strata:
        observed += k if 10 * b <= whole else 0
        t, further = k + b, dict[int, int]()
        for drawn in range(max(0, t - m), min(n, t) + 1):
            gain = drawn if 10 * (t - drawn) <= whole else 0
            for so_far, count in sums.items():
                further[so_far + gain] = further.get(so_far + gain, 0) + count * comb(n, drawn) * comb(m, t - drawn)
        sums, ways = further, ways * comb(n + m, t)
    return Fraction(sum(count for total, count in sums.items() if total >= observed), ways)


def holm(
    flights: dict[str, list[Row]],
    table: dict[tuple[str, str], Row],
    names: list[str],
    gone: dict[str, Row] | None = None,
) -> dict[str, Fraction]:
    """p of each requirement; `gone`: by situation a flight that leaves the pool."""
    raw = {}
    for name in names:
        strata = []
        for key, rows in flights.items():
            pair = table.get((key, name))
            if pair and pair["state"] in ("steady", "red", "unsteady"):
                k = sum(name in row["violated"] for row in rows)
                b, m = pair["violated"], pair["flights"] - pair["open"]
                left = (gone or {}).get(key)
                out = left is not None and name in left["violated"]
                judged = left is not None and (out or name in left["held"])
                strata.append((k, len(rows), b - out, m - judged, m))
        raw[name] = exact(strata)
    found, worst = {}, Fraction(0)
    for rank, name in enumerate(sorted(names, key=lambda name: raw[name])):
        worst = max(worst, min(Fraction(1), (len(names) - rank) * raw[name]))
        found[name] = worst
    return {name: found[name] for name in names}


def verdict(
    flights: dict[str, list[Row]], acts: set[str], table: dict[tuple[str, str], Row], names: list[str], alpha: Fraction
) -> Row:
    """The verdict on a mutant that was asked for once, by requirements of one kind.

    Args:
        flights: per situation the flights that count, by seed.
        acts: situations where the fault changed a sample.
        table: the pairs.
        names: the requirements.
        alpha: accepted error.
    """
    steady = {key: [n for n in names if state(table, key, n) == "steady"] for key in flights}
    tested = [key for key in flights if key in acts and steady[key]]
    blind = [key for key in acts if all(state(table, key, n) == "unknown" for n in names)]
    if not tested:
        return {"verdict": "undecided" if blind and names else "not_tested", "p": dict.fromkeys(names, Fraction(1))}
    p = holm(flights, table, names)
    if min(p.values()) <= alpha:
        return {"verdict": "detected", "p": p}
    seen = any(name in row["violated"] for key in tested for name in steady[key] for row in flights[key])
    worst = {key: [{"violated": steady[key]}] * len(flights[key]) for key in tested}
    able = min(holm(worst, table, names).values()) <= alpha
    return {"verdict": "undecided" if seen or blind or not able else "not_detected", "p": p}


def firm(
    flights: dict[str, list[Row]],
    acts: set[str],
    pool: list[Row],
    table: dict[tuple[str, str], Row],
    names: list[str],
    alpha: Fraction,
) -> str:
    """What remains of `detected` without any one seed of the mutant or of the pool; arguments as for `verdict`."""
    own = sorted({row["seed"] for rows in flights.values() for row in rows})
    cases: list[tuple[dict[str, list[Row]], dict[str, Row]]] = [
        ({key: [row for row in rows if row["seed"] != seed] for key, rows in flights.items()}, {})
        for seed in (own if len(own) > 1 else [])
    ]
    cases += [
        (flights, {row["situation"]: row for row in pool if row["seed"] == seed and row["counts"]})
        for seed in {row["seed"] for row in pool if row["counts"]}
    ]
    lost = [case for case in cases if min(holm(case[0], table, names, case[1]).values()) > alpha]
    if not lost:
        return "firm" if len(own) > 1 else "firm_by_pool"
    for some, gone in lost:
        worst = {}
        for key in acts & some.keys():
            steady = [name for name in names if state(table, key, name) == "steady"]
            worst |= {key: [{"violated": steady}] * len(some[key])} if steady else {}
        if min(holm(worst, table, names, gone).values()) <= alpha:
            return "hangs_on_a_seed"
    return "too_few_seeds"


def covered(rows: list[Row], axes: dict[str, dict[str, str]], kinds: dict[str, str]) -> Row:
    """`axes` has per situation of the grid the value of each axis."""
    valid = [row for row in rows if row["counts"] and row["situation"] in axes]
    base = [row for row in valid if row["mutant"] == "baseline"]
    keys, judged_keys = {row["situation"] for row in valid}, {row["situation"] for row in base}
    names = list(next(iter(axes.values())))
    safety = [pair for pair in pairs(base, kinds) if pair["kind"] == "safety"]
    ways, complete = {}, {}
    for strength in range(1, 6):
        per = []
        for chosen in combinations(names, strength):
            seen, every = ({tuple(axes[k][a] for a in chosen) for k in some} for some in (keys, axes.keys()))
            per.append((len(seen), len(every)))
        ways[str(strength)] = share(sum(s for s, _ in per), sum(e for _, e in per))
        complete[str(strength)] = {p: share(sum(s >= float(p) * e for s, e in per), len(per)) for p in SHARES}

    def situations(rows: list[Row]) -> int:
        return len({row["situation"] for row in rows})

    return {
        "situations": share(len(keys), len(axes)),
        "draws": len({(row["situation"], row["seed"]) for row in valid}),
        "pool": len(
            {(r["situation"], r["seed"]) for r in base}
            - {(r["situation"], r["seed"]) for r in valid if r["mutant"] != "baseline"}
        ),
        "t_way": ways,
        "complete": complete,
        "realised": share(situations([row for row in base if row["realised"] == names]), len(axes)),
        "realised_by_axis": {
            axis: share(situations([row for row in base if axis in row["realised"]]), len(judged_keys))
            for axis in names
        },
        "steady": share(
            sum(pair["state"] == "steady" for pair in safety), sum(pair["state"] != "unknown" for pair in safety)
        ),
        "states": {
            state: sum(pair["state"] == state for pair in safety)
            # a situation where mutants flew and no baseline counts is unknown by every requirement that is known
            + (state == "unknown") * len(keys - judged_keys) * len({pair["requirement"] for pair in safety})
            for state in ("unknown", "vacuous", "open", "steady", "red", "unsteady")
        },
        "requirements": {
            name: share(
                situations(
                    [r for r in base if name in r["violated"] or (name in r["held"] and name in r["triggered"])]
                ),
                len(judged_keys),
            )
            for name in (kinds if base else ())
        },
    }


def score(
    text: str, *, kinds: dict[str, str], axes: dict[str, dict[str, str]], defaults: set[str], controls: set[str]
) -> Row:
    """What `score --format json` must say about the CSV `text` of `export`.

    Args:
        text: the export.
        kinds: of each requirement.
        axes: per situation of the grid, in its order, the value of each axis.
        defaults: ids of the default mutants of the credible cells.
        controls: names of the control cells.
    """
    rows, order, alpha = read(text), list(axes), Fraction(1, 100)
    pool = [row for row in rows if row["mutant"] == "baseline"]
    base = {(row["situation"], row["seed"]): row for row in pool}
    table = {(pair["situation"], pair["requirement"]): pair for pair in pairs(pool, kinds)}
    known = {key for (key, _), pair in table.items() if pair["state"] != "unknown"}
    judged = {name for _, name in table}
    by_kind = {
        kind: [name for name, own in kinds.items() if own == kind and name in judged]
        for kind in ("safety", "operability")
    }
    listed: dict[str, list[Row]] = {}
    for row in rows:
        if row["mutant"] != "baseline":
            its = base.get((row["situation"], row["seed"]))
            row["status"], told = status(row, its, kinds), row["status"]
            assert told == ("waiting" if its is None and row["counts"] else row["status"][0]), row
            assert row["status"][1] == row["revealed_by"], row
            listed.setdefault(row["mutant"], []).append(row)

    mutants: list[Row] = []
    others: list[Row] = []
    acted: set[str] = set()
    for id_, own in listed.items():
        flights: dict[str, list[Row]] = {}
        for row in sorted(own, key=lambda row: (order.index(row["situation"]), row["seed"])):
            if row["status"][0] != "invalid":
                flights.setdefault(row["situation"], []).append(row)
        acts = {key for key, some in flights.items() if any(row["altered"] for row in some)}
        if id_ == "PLACEBO":
            continue
        acted |= acts if id_.partition("@")[0] not in controls else set()
        by_safety, by_operability = (
            verdict(flights, acts, table, by_kind[kind], alpha) for kind in ("safety", "operability")
        )
        said = {}
        for kind, found in (("safety", by_safety), ("operability", by_operability)):
            said[kind] = [
                {"situation": key, "requirement": name, "violated": count, "flights": len(some)}
                for key, some in flights.items()
                for name in by_kind[kind]
                if found["verdict"] == "detected" and key in acts and state(table, key, name) == "steady"
                if 2 * (count := sum(name in row["violated"] for row in some)) > len(some)
            ]
        testing = {
            name: [key for key in flights if key in acts and state(table, key, name) == "steady"] for name in kinds
        }
        kills = {n: sum(kill["requirement"] == n for kill in said["safety"] + said["operability"]) for n in kinds}
        hit = len({kill["situation"] for kill in said["safety"]})
        tested = len({key for name in by_kind["safety"] for key in testing[name]})
        cell, _, magnitude = id_.partition("@")
        guideword, _, parameter = cell.partition("-")
        entry = {
            "id": id_,
            "guideword": guideword,
            "parameter": parameter,
            "magnitude": magnitude,
            "status": max((row["status"][0] for row in own), key=LADDER.index),
            "verdict": by_safety["verdict"],
            "firm": firm(flights, acts, pool, table, by_kind["safety"], alpha)
            if by_safety["verdict"] == "detected"
            else None,
            "p": {name: float(p) for name, p in by_safety["p"].items()},
            "kill_rate": share(hit, tested),
            "kill_rate_flown": share(hit, len(flights)),
            "kills": said["safety"],
            "requirements": {name: share(kills[name], len(testing[name])) for name in kinds if kills[name]},
            "operability": {
                "verdict": by_operability["verdict"],
                "p": {name: float(p) for name, p in by_operability["p"].items()},
                "kills": said["operability"],
            },
            "flown": bool(flights),
            "acts": bool(acts),
            "behaviour": sorted((key, row["seed"], row["digest"]) for key, some in flights.items() for row in some),
            "acted": share(
                sum(row["altered"] > 0 for some in flights.values() for row in some), sum(map(len, flights.values()))
            ),
            "early": any(
                row["at"][kill["requirement"]][0] <= 5.0
                for kill in said["safety"]
                for row in flights[kill["situation"]]
                if kill["requirement"] in row["at"]
            ),
        }
        (others if cell in controls else mutants).append(entry)
    counted = [entry for entry in mutants if entry["id"] in defaults]
    pooled = not acted or bool(acted & known)
    violated: dict[str, set[str]] = {}
    for row in sorted(pool, key=lambda row: order.index(row["situation"])):
        if row["counts"]:
            violated.setdefault(row["situation"], set()).update(row["violated"])
    whole = len(counted) if pooled else 0
    tested_in_all = sum(entry["kill_rate"]["whole"] > 0 for entry in counted)
    detected = sum(entry["verdict"] == "detected" for entry in counted)
    operable = sum(entry["operability"]["verdict"] == "detected" for entry in counted)
    return {
        "alpha": 0.01,
        "pooled": pooled,
        "ratios": {
            "exercised": share(sum(entry["flown"] for entry in counted), len(defaults)),
            "infected": share(sum(entry["acts"] for entry in counted), len(counted)),
            "tested": share(tested_in_all, len(counted)),
            "mutation_score": share(detected, whole),
            "firm": share(sum(entry["firm"] in ("firm", "firm_by_pool") for entry in counted) if pooled else 0, whole),
            "operability": share(operable, whole if violated else 0),
        },
        "composition": _composition(counted),
        "expected_false": 0.01 * tested_in_all,
        "mutants": [_told(entry) for entry in mutants],
        "controls": [_told(entry) for entry in others],
        "pairs": sorted(table.values(), key=lambda pair: order.index(pair["situation"])),
        "lacking": sorted(acted - known, key=order.index),
        "proposed": [],
        "selected": [],  # the grids of these tests have no found situation
        "coverage": covered(rows, axes, kinds),
        "baseline": [
            {"situation": key, "violated": [name for name in kinds if name in names]} for key, names in violated.items()
        ],
    }


def _composition(counted: list[Row]) -> Row:
    """What the ratio is made of."""
    detected = [entry for entry in counted if entry["verdict"] == "detected"]
    alike: dict[str, list[str]] = {}
    for entry in detected:
        alike.setdefault(str(entry["behaviour"]), []).append(entry["id"])
    return {
        "behaviours": list(alike.values()),
        "without_kill": [entry["id"] for entry in detected if not entry["kills"]],
        "trivial": [
            entry["id"]
            for entry in detected
            if entry["early"] or 10 * entry["kill_rate"]["part"] >= 9 * entry["kill_rate"]["whole"] > 0
        ],
        "without_effect": [
            {"id": entry["id"], "acted": entry["acted"]}
            for entry in counted
            if entry["status"] != "invalid" and LADDER.index(entry["status"]) <= LADDER.index("masked")
        ],
    }


def _told(entry: Row) -> Row:
    hidden = ("flown", "acts", "behaviour", "acted", "early")
    return {name: value for name, value in entry.items() if name not in hidden}
