"""A corpus of crafted stores: what somebody could hand over as a campaign, and what is said of it."""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from options import usually
from paper_flyer import made

from scaloft_fi.campaign.store.held import Keys, flight_named, remember_seeds
from scaloft_fi.campaign.store.platforms import fingerprint
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import TRACK_COLUMNS, pack_track
from scaloft_fi.study import Study

HERE = "T0O0W0D0H1"
LATE = "LATE-human@3s"
FLOWN = (("baseline", 10), ("PLACEBO", 3), (LATE, 3), ("NO-human@100%", 3))
ONE = f"WHERE mutant = '{LATE}' AND seed = 1"
DEEP = "[" * 20_000
ENDLESS = "WITH RECURSIVE r (id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM r) SELECT id, 'k' AS key FROM r"


def campaign(study: Study, path: Path) -> None:
    """A small campaign: LATE-human kills, NO-human survives, every flight with a track."""
    keys, kinds = Keys(study), {r.name: r.kind for r in study.requirements}
    with Store(path) as store:
        store.set_meta(fingerprint())
        remember_seeds(store, [LATE, "NO-human@100%"], range(3))
        choice = {"choose": "random:1", "seed": 0, "pool": 32, "draws": [[HERE, 0]]}
        store.set_notes({"choice 0123": json.dumps(choice)})
        for mutant, seeds in FLOWN:
            for seed in range(seeds):
                planned = keys.planned(flight := flight_named(study, mutant, HERE, seed))
                store.plan([planned])
                violated = {"SR2": 8.0} if mutant == LATE else {}
                altered = "-" in mutant
                store.put(
                    planned.key,
                    made(
                        *(flight.subject, HERE, seed, kinds, violated),
                        rho=(-1.0, 0.5),
                        carried=10,
                        altered=3 * altered,
                        infected_at_s=1.0 if altered else None,
                        duration_s=20.0,
                        digest=f"{mutant * altered}{seed}",
                        realised=() if flight.mutant else tuple((axis.id, True) for axis in study.grid.axes),
                        track=pack_track({name: [i / 20 + seed for i in range(40)] for name in TRACK_COLUMNS}),
                    ),
                )


@dataclass(frozen=True)
class Crafted:
    """One store.

    Attributes:
        name: what is wrong.
        make: changes the file of a good campaign.
        says: part of the refusal; empty if some verbs may read the store.
        by: a verb that refuses it; `export` reads every column.
    """

    name: str
    make: Callable[[Path], object]
    says: str = ""
    by: tuple[str, ...] = ("export",)


def crafted() -> Iterator[Crafted]:
    """The corpus."""
    yield from _cells()
    yield from _lines()
    yield from _tracks()
    yield from _tables()
    yield from _files()


def _cells() -> Iterator[Crafted]:
    key = "table outcomes, key '"
    for column, value in (
        ("mutant", b"\0"),
        ("magnitude", "m" * 300),
        ("seed", "many"),
        ("seed", -1),
        ("seed", 2**62),
        ("seed", 1e308),
        ("ending", "\x1b[31m"),
        ("struck", b"\xff"),
        ("carried", -5),
        ("altered", "x"),
        ("infected_at_s", float("inf")),
        ("duration_s", None),
        ("duration_s", "long"),
        ("invalid", b""),
        ("digest", b"\0\xff"),
        ("stack_error", "e" * 100_000),
    ):
        row = "table outcomes, id " if column == "stack_error" else key
        says = f": {column}="
        yield Crafted(
            f"{column} {value!r:.12}", sql(f"UPDATE outcomes SET {column} = ? {ONE}", value), row + "|" + says
        )
    situation = sql(f"UPDATE outcomes SET situation = 'T0' || char(7) {ONE}")
    yield Crafted("situation", situation, f"{key}|: situation='T0\\x07'", ("status",))
    yield Crafted("no text", sql(f"UPDATE outcomes SET digest = CAST(X'FFFE' AS TEXT) {ONE}"), "id |: digest=")
    yield Crafted(
        "20 MB of text", sql(f"UPDATE outcomes SET invalid = CAST(zeroblob(20000000) AS TEXT) {ONE}"), "id |="
    )
    plan = ("table plan, key '|: mutant=", ("status",))
    yield Crafted("mutant of a plan", sql(f"UPDATE plan SET mutant = X'00' {ONE}"), *plan)
    yield Crafted("meta", sql("UPDATE meta SET value = X'00' WHERE name = 'numpy'"), "table meta, name 'numpy': value=")
    for text in ("{}", DEEP, '{"sim": 1}', "x" * 5000):
        says = "table origins, id |: parts="
        yield Crafted(f"origin {text:.9}", sql("UPDATE origins SET parts = ? WHERE id = 1", text), says)
    for note, by in (("choice", "coverage"), ("asked", "score")):
        for text in ("", "[]", DEEP, '{"seeds": [1e999], "mutants": [1], "choose": "", "seed": 1%s}' % ("0" * 4000)):
            set_note = sql(f"UPDATE meta SET value = ? WHERE name LIKE 'note: {note} %'", text)
            yield Crafted(f"note {note} {text:.9}", set_note, f"table meta, name 'note: {note} |: value=", (by,))


def _lines() -> Iterator[Crafted]:
    for column, line in (
        ("readings", '["SR2", "odd", -1.0, 8.0, 1, false]'),
        ("readings", '["SR2", "safety", 1e999, 8.0, 1, false]'),
        ("readings", '["SR2", "safety", NaN, 8.0, 1, false]'),
        ("readings", '["SR2", "safety", -1.0, "8", 1, false]'),
        ("readings", '["SR2", "safety", -1.0, 8.0, -1, false]'),
        ("readings", '["SR2", "safety", -1.0, 8.0, 1, 0]'),
        ("readings", '["SR2", "safety", -1.0, 8.0, 1]'),
        ("readings", '["\\ud800", "safety", -1.0, 8.0, 1, false]'),
        ("readings", f'["SR2", "safety", 1{"0" * 400}, 8.0, 1, false]'),
        ("readings", '{"a": 1, "b": 2, "c": 3, "d": 4, "e": 5, "f": 6}'),
        ("readings", DEEP),
        ("readings", "[[],[]]\n" * 3000),
        ("readings", b"\0"),
        ("violations", '["SR2", "safety", 8.0, 0.0, null, 1.6, ""]'),
        ("violations", '["SR2", "safety", 8.0, 0.0, 1.0, 1.6, 3]'),
        ("violations", "null"),
        ("violations", '["SR2", "safety", 8.0, 0.0, 1.0, 1.6, ""]\n["SR2", "safety", 9.0, 0.0, 1.0, 1.6, ""]'),
        ("realised", '["T", 1]'),
        ("realised", '[["T"], true]'),
    ):
        says = f"table outcomes, key '|: {column}="
        yield Crafted(f"{column} {line!r:.45}", sql(f"UPDATE outcomes SET {column} = ? {ONE}", line), says)


def _tracks() -> Iterator[Crafted]:
    row = [0.0] * len(TRACK_COLUMNS)
    for name, track in (
        ("zlib bomb", zlib.compress(bytes(30_000_000), 9)),
        ("longer than a flight", zlib.compress(bytes(4 * len(row) * 5000))),
        ("no zlib", b"abc"),
        ("broken off", zlib.compress(bytes(2800))[:-5]),
        ("half a row", zlib.compress(b"abcd")),
        ("not a number", zlib.compress(b"\0\0\xc0\x7f" * len(row) * 5)),
        ("infinite", zlib.compress(b"\0\0\x80\x7f" * len(row) * 5)),
        ("text", "track"),
    ):
        says = "table outcomes, key '|: track='" if track == "track" else f"the track of |/{HERE}/"
        yield Crafted(f"track {name}", sql("UPDATE tracks SET track = ?", track), says, ("report", "--output", "OUT"))
    yield Crafted("a track of 20 MB", sql("UPDATE tracks SET track = zeroblob(20000000)"), "too big", ("report",))
    yield Crafted("tracks gone", sql("DELETE FROM tracks"))
    yield Crafted("origins gone", sql("DELETE FROM origins"))
    yield Crafted("plan gone", sql("DELETE FROM plan"))
    yield Crafted("one origin", sql("UPDATE outcomes SET origin = (SELECT origin FROM plan LIMIT 1)"))


def _tables() -> Iterator[Crafted]:
    no_store = "this file is no store of scaloft-fi: it "
    for name, statements in (
        ("extra table", ["CREATE TABLE extra (a)"]),
        ("view", [f"CREATE VIEW v AS {ENDLESS}"]),
        ("endless view for a table", ["DROP TABLE outcomes", f"CREATE VIEW outcomes AS {ENDLESS}"]),
        ("trigger", ["CREATE TRIGGER t AFTER INSERT ON plan BEGIN SELECT 1; END"]),
        ("generated column", ["ALTER TABLE plan ADD COLUMN g AS (seed + 1)"]),
        ("index gone", ["DROP INDEX invalid_outcomes"]),
        ("no tables", [f"DROP TABLE {name}" for name in ("outcomes", "plan", "origins", "tracks", "meta")]),
    ):
        yield Crafted(name, _all(*statements), no_store)
    loosened = "UPDATE sqlite_master SET sql = replace(sql, 'seed INTEGER NOT NULL', 'seed') WHERE name = 'outcomes'"
    yield Crafted("other types", _all("PRAGMA writable_schema=ON", loosened), no_store)
    swapped = "UPDATE sqlite_master SET rootpage = (SELECT rootpage FROM sqlite_master WHERE name = 'tracks')"
    yield Crafted(
        "swapped", _all("PRAGMA writable_schema=ON", f"{swapped} WHERE name = 'outcomes'"), "outcomes.sqlite: "
    )


def _files() -> Iterator[Crafted]:
    yield Crafted("empty", lambda path: path.write_bytes(b""), "the file has no tables, so it holds no campaign")
    yield Crafted("notes", lambda path: path.write_text("notes of mine\n" * 500), "file is not a database")
    yield Crafted("a letter", lambda path: path.write_text("a"), "the file has no tables")
    yield Crafted("alien", lambda path: (path.unlink(), _all("CREATE TABLE mine (a)")(path)), "has the table 'mine'")
    yield Crafted("no UTF-8 in the tables", _misspelt, "sqlite: the campaign's store cannot be used")
    yield Crafted("cut", lambda path: path.write_bytes(path.read_bytes()[:-30_000]))
    for place in range(40, 16_384 * 12, usually(3, release=1) * (16_384 // 2 + 7)):
        yield Crafted(f"damaged at {place}", _damaged(place))


def sql(statement: str, *values: object) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute(statement, values)

    return make


def _all(*statements: str) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            for statement in statements:
                connection.execute(statement)

    return make


def _misspelt(path: Path) -> None:
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE origins (id", b"CREATE TABL\x86 \xf1rigins (id"))


def _damaged(place: int) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        content = bytearray(path.read_bytes())
        content[place : place + 60] = bytes(range(7, 247, 4))
        path.write_bytes(content)

    return make
