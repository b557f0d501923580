"""The score again, from the rows of `export` alone: plain Python that shares no code with what it checks.

Statuses are judged anew from each flight's facts, so that an error of `status` shows as well.
"""

from __future__ import annotations

import csv
import io
from itertools import combinations, permutations
from math import sqrt
from typing import Any

from scipy.stats import binom, hypergeom

Row = dict[str, Any]
LADDER = ["invalid", "not_reached", "not_infected", "masked", "baseline_red", "survived", "killed"]
SHARES = ("0.5", "0.75", "1")
SPEND = {3: 0.0, 5: 0.05 * 2 / 3, 10: 0.05 / 3}
TINY = 1e-12
"""Floats that are equal but for rounding."""


def read(text: str) -> list[Row]:
    rows: list[Row] = []
    for cells in csv.DictReader(io.StringIO(text)):
        row: Row = dict(cells)
        for name in ("violated", "held", "killed_by", "triggered", "realised", "violation_times_s"):
            row[name] = [part for part in cells[name].split(";") if part]
        bodies = cells["violation_bodies"].split(";") if row["violated"] else []
        times = map(float, row["violation_times_s"])
        row["at"] = dict(zip(row["violated"], zip(times, bodies, strict=True), strict=True))
        row |= {name: int(cells[name]) for name in ("seed", "carried", "altered")}
        row["duration_s"] = float(cells["duration_s"])
        row["counts"] = cells["ending"] != ""
        rows.append(row)
    return rows


def killers(row: Row, base: Row, kinds: dict[str, str], kind: str) -> list[str]:
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


def judged(row: Row, base: Row | None, kinds: dict[str, str]) -> Row:
    """Status, killers of both kinds, requirements put to the test."""
    said: Row = {"row": row, "kills": [], "stops": [], "tested": [], "safe": False, "operable": False}
    if base is None or not row["counts"] or not base["counts"]:
        return said | {"status": "invalid"}
    if row["altered"] == 0:
        return said | {"status": "not_infected" if row["carried"] else "not_reached"}
    said["tested"] = [name for name in base["held"] if kinds[name] != "reported"]
    said["safe"] = any(kinds[name] == "safety" for name in base["held"])
    said["operable"] = any(kinds[name] == "operability" for name in base["held"])
    if row["digest"] == base["digest"]:
        return said | {"status": "masked"}
    said["kills"] = killers(row, base, kinds, "safety")
    said["stops"] = killers(row, base, kinds, "operability")
    red = any(kinds[name] == "safety" for name in row["violated"])
    return said | {"status": "killed" if said["kills"] else "baseline_red" if red else "survived"}


def wilson(part: int, whole: int) -> list[float] | None:
    if not whole:
        return None
    z2, p = 3.8414588206941254, part / whole
    centre, half = p + z2 / 2 / whole, sqrt(z2 * (p * (1 - p) / whole + z2 / 4 / whole**2))
    return [(centre - half) / (1 + z2 / whole), (centre + half) / (1 + z2 / whole)]


def ratio(part: int, whole: int) -> Row:
    return {"part": part, "whole": whole, "interval": wilson(part, whole)}


def share(part: int, whole: int) -> Row:
    return {"part": part, "whole": whole}


def infected(flight: Row) -> bool:
    return LADDER.index(flight["status"]) >= LADDER.index("masked")


def highest(flights: list[Row]) -> str:
    said = [flight["status"] for flight in flights if flight["safe"]]
    if not said:
        said = [
            "baseline_red" if LADDER.index(f["status"]) > LADDER.index("baseline_red") else f["status"] for f in flights
        ]
    return max(said, key=LADDER.index)


def decided(flights: list[Row], pool: list[Row], kinds: dict[str, str], order: list[str]) -> dict[str, Row]:
    """The rule of killed, survived and undecided, per situation with an eligible flight."""
    safety = [name for name, kind in kinds.items() if kind == "safety"]
    by_key: dict[str, list[Row]] = {}
    for flight in sorted(flights, key=lambda flight: flight["row"]["seed"]):
        if flight["status"] != "invalid":
            by_key.setdefault(flight["row"]["situation"], []).append(flight)
    by_key = {key: by_key[key] for key in sorted(by_key)}

    def baselines(key: str, name: str) -> tuple[int, int]:
        rows = [row for row in pool if row["situation"] == key and row["counts"]]
        red = sum(name in row["violated"] for row in rows)
        return red, red + sum(name in row["held"] for row in rows)

    family = {
        key: [name for name in safety if len(listed) < 3 or any(name in f["tested"] for f in listed[:3])]
        for key, listed in by_key.items()
    }
    counts = {(key, name): baselines(key, name) for key in by_key for name in safety}
    settled: dict[str, Row] = {}
    latest: dict[str, Row] = {}
    left = sum(map(len, family.values()))
    could: set[str] = set()
    for look, spent in SPEND.items():
        due = [key for key, listed in by_key.items() if len(listed) >= look and key not in settled]
        tests = []
        for key in due:
            for name in safety:
                b, n0 = counts[key, name]
                k = sum(name in f["row"]["violated"] for f in by_key[key][:look])
                p = float(hypergeom.sf(k - 1, look + n0, k + b, look))
                floor = bool(n0) and k * n0 * 5 - b * look * 5 >= look * n0
                if floor and 3 * p <= 0.05 + TINY:
                    could.add(key)
                entry = {"situation": key, "requirement": name, "p": p, "look": look}
                entry |= {"flights": share(k, look), "baseline": share(b, n0), "floor": floor}
                if name in family[key]:
                    tests.append(entry)
        tests.sort(key=lambda entry: entry["p"])
        worst = 0.0
        for entry in tests:
            adjusted = max(worst, 3 * left * entry["p"])
            if adjusted > 0.05 + TINY:
                break
            if entry["floor"] and entry["situation"] not in settled:
                settled[entry["situation"]] = entry | {"decision": "killed", "p": adjusted}
                worst, left = adjusted, left - len(family[entry["situation"]])
        for key in due:
            kills = sum(f["safe"] and f["status"] == "killed" for f in by_key[key][:look])
            safe = sum(f["safe"] for f in by_key[key][:look])
            tail = float(binom.cdf(kills, safe, 0.5))
            if key in settled:
                continue
            nothing = {"situation": key, "requirement": "", "look": look, "baseline": share(0, 0)}
            if spent and tail <= spent + TINY and key not in could:
                survival = {"decision": "survived", "p": tail * 0.05 / spent, "flights": share(kills, safe)}
                settled[key] = nothing | survival
                continue
            mine = [entry for entry in tests if entry["situation"] == key]
            best = min(mine, key=lambda entry: entry["p"], default=nothing | {"p": 1.0, "flights": share(0, 0)})
            p = min(1.0, 3 * left * best["p"]) if mine else 1.0
            latest[key] = best | {"decision": "undecided", "p": p}
    said = latest | settled
    for entry in said.values():
        entry.pop("floor", None)
    safe_keys = [key for key, listed in by_key.items() if any(f["safe"] for f in listed)]
    unseen = {"decision": "undecided", "look": 0}
    return {key: said.get(key, unseen) for key in sorted(safe_keys, key=order.index)}


def redrawn(pool: list[Row], kinds: dict[str, str], eligible: dict[str, int], order: list[str]) -> Row:
    by_key: dict[str, list[Row]] = {}
    for row in sorted(pool, key=lambda row: row["seed"]):
        if row["counts"]:
            by_key.setdefault(row["situation"], []).append(row | {"altered": 1, "carried": 1})
    rates: dict[str, tuple[int, int]] = {}
    for key, rows in by_key.items():
        pairs = [judged(second, first, kinds) for first, second in permutations(rows, 2)]
        if pairs:
            kills = sum(pair["safe"] and pair["status"] == "killed" for pair in pairs)
            rates[key] = kills, sum(pair["safe"] for pair in pairs)
    known = {key: n for key, n in eligible.items() if n and rates.get(key, (0, 0))[1]}
    left_out = max((n for n in SPEND if any(len(rows) >= 2 * n for rows in by_key.values())), default=0)
    killed = blocks = 0
    if left_out:
        enough = {key: rows for key, rows in by_key.items() if len(rows) >= 2 * left_out}
        blocks = min(len(rows) // left_out for rows in enough.values())
        for block in range(blocks):
            flights, rest = [], []
            for rows in enough.values():
                out = rows[block * left_out : (block + 1) * left_out]
                stay = [row for row in rows if row not in out]
                flights += [judged(row, base, kinds) for row, base in zip(out, stay, strict=False)]
                rest += stay
            killed += any(entry["decision"] == "killed" for entry in decided(flights, rest, kinds, order).values())
    return {
        "rate": share(sum(k for k, _ in rates.values()), sum(n for _, n in rates.values())),
        "expected_false_kills": sum(rates[k][0] / rates[k][1] * n for k, n in known.items()) if known else None,
        "eligible_flights": sum(known.values()),
        "decided": {"seeds": left_out, **share(killed, blocks)},
    }


def covered(rows: list[Row], axes: dict[str, dict[str, str]], kinds: dict[str, str]) -> Row:
    """`axes` has per situation of the grid the value of each axis."""
    valid = [row for row in rows if row["counts"] and row["situation"] in axes]
    base = [row for row in valid if row["mutant"] == "baseline"]
    keys, judged_keys = {row["situation"] for row in valid}, {row["situation"] for row in base}
    names = list(next(iter(axes.values())))
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
        "eligible": share(
            situations([row for row in base if any(kinds[name] == "safety" for name in row["held"])]), len(axes)
        ),
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
    text: str,
    *,
    kinds: dict[str, str],
    axes: dict[str, dict[str, str]],
    defaults: set[str],
    controls: set[str],
) -> Row:
    """What `score --format json` must say about the CSV `text` of `export`.

    Args:
        text: the export.
        kinds: of each requirement.
        axes: per situation of the grid, in its order, the value of each axis.
        defaults: ids of the default mutants of the credible cells.
        controls: names of the control cells.
    """
    rows, order = read(text), list(axes)
    pool = [row for row in rows if row["mutant"] == "baseline"]
    base = {(row["situation"], row["seed"]): row for row in pool}
    flights: dict[str, list[Row]] = {}
    for row in rows:
        if row["mutant"] != "baseline":
            flight = judged(row, base.get((row["situation"], row["seed"])), kinds)
            assert flight["status"] == row["status"], row
            assert flight["kills"] + flight["stops"] == row["killed_by"], row
            flights.setdefault(row["mutant"], []).append(flight)

    mutants, eligible = [], dict.fromkeys(order, 0)
    flown = infect = able = killed = operable = stopped = settled = decidable = 0
    for id_, listed in flights.items():
        cell, _, magnitude = id_.partition("@")
        if id_ == "PLACEBO" or cell in controls:
            continue

        def keys(chosen: list[Row]) -> set[str]:
            return {flight["row"]["situation"] for flight in chosen}

        valid = [flight for flight in listed if flight["status"] != "invalid"]
        safe = [flight for flight in valid if flight["safe"]]
        dead = [flight for flight in valid if flight["status"] == "killed"]
        dead_safe = keys([flight for flight in dead if flight["safe"]])
        said = decided(listed, pool, kinds, order)
        by = {}
        for name in kinds:
            tested = [flight for flight in valid if name in flight["tested"]]
            hit = keys([flight for flight in tested if name in flight["kills"] + flight["stops"]])
            if hit:
                by[name] = share(len(hit), len(keys(tested)))
        guideword, _, parameter = cell.partition("-")
        mutants.append(
            {
                "id": id_,
                "guideword": guideword,
                "parameter": parameter,
                "magnitude": magnitude,
                "status": highest(listed),
                "kill_rate": share(len(dead_safe), len(keys(safe))),
                "kill_rate_flown": share(len(keys(dead)), len(keys(valid))),
                "requirements": by,
                "decisions": {
                    **{
                        word: sum(entry["decision"] == word for entry in said.values())
                        for word in ("killed", "survived", "undecided")
                    },
                    "situations": [entry for entry in said.values() if entry["look"]],
                },
            }
        )
        if id_ in defaults and valid:
            flown += 1
            infect += any(infected(flight) for flight in valid)
            able += bool(safe)
            killed += bool(dead_safe)
            operable += any(flight["operable"] for flight in valid)
            settled += any(entry["decision"] == "killed" for entry in said.values())
            decidable += any(entry["look"] for entry in said.values())
            stopped += any(flight["operable"] and flight["stops"] for flight in valid)
            for flight in safe:
                eligible[flight["row"]["situation"]] += 1
    violated = {}
    for row in sorted(pool, key=lambda row: order.index(row["situation"])):
        if row["counts"]:
            violated.setdefault(row["situation"], set()).update(row["violated"])
    return {
        "ratios": {
            "exercised": ratio(flown, len(defaults)),
            "infected": ratio(infect, flown),
            "mutation_score": ratio(killed, able),
            "strict_score": ratio(killed, flown),
        },
        "mutants": mutants,
        "coverage": covered(rows, axes, kinds),
        "baseline": [
            {"situation": key, "violated": [name for name in kinds if name in names]} for key, names in violated.items()
        ],
        "decided_score": ratio(settled, decidable),
        "operability": ratio(stopped, operable),
        "redraw": redrawn(pool, kinds, eligible, order),
    }
