"""A suite of one's own tests: the file that declares it, a run of one of its commands, and what that says of each test.

A command is a test, or many that its JUnit file tells apart.  A test is green or red; a command that cannot be started,
runs too long, is killed or ends with a code that is neither says nothing of the drone, and its tests are unknown.

A fault reaches a test by the flights that the test flies from Python, `scaloft_fi.open().fly(...)`, which fly the fault
that the environment names; by a relay between two topics of the tested system; or by the command itself, which gets it
in `{fault}`.  Each says how many samples the fault altered; a test that no altered sample has reached shows nothing.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from enum import StrEnum
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, NamedTuple
from xml.etree import ElementTree

from scaloft_fi.document import Item, digest, is_file, is_folder, is_there, read_bytes, read_text
from scaloft_fi.errors import InputError
from scaloft_fi.marks import MOST, Bounds, Examples, Given, Size
from scaloft_fi.mutants.mutant import EVERY_SEAM, Mutant
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.outside import command as commands
from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.exchange import DONE, FlightFolder
from scaloft_fi.registry import in_one_line
from scaloft_fi.stack.declaration import Declaration, Wire

JUNIT, MUTANT = "junit", "mutant"
INJECTED, REACHED = "SCALOFT_FI_MUTANT", "SCALOFT_FI_REACHED"
"""Environment variables: the fault that the flights of a test fly; the file to which each adds what it altered."""
_JUNIT_BYTES = 1 << 26
_RUN = Examples(("{python}", "-m", "pytest", "-q", "tests", "--junitxml={junit}"))


@dataclass(frozen=True)
class SuiteCommand:
    """A command of a suite.

    Attributes:
        run: program and arguments; {python}, {junit}, {folder}, {seed}, {mutant} and {fault} stand in braces.  With
            {junit} it writes a JUnit file there, and each test case of that file is a test; else it is one test.
        inputs: files and folders, below that of the suite, that decide what is tested; a changed one runs again.
        red: the codes with which it ends where the test is red; 0 is green, any other says nothing of the drone.
        limit_s: longest time of a run [s, wall].
        env: environment variables beside ours; with the same places in braces.
        seams: the seams whose faults the command injects itself, as it gets them in {fault}.
    """

    run: Annotated[tuple[commands.Word, ...], Size(1, MOST, "a list that begins with a program"), _RUN]
    inputs: Annotated[tuple[str, ...], Size(), Examples(("tests",))] = ()
    red: Annotated[tuple[Annotated[int, Bounds(least=1, most=255)], ...], Size(1, 255, "codes from 1 to 255")] = (1,)
    limit_s: Annotated[float, Bounds(above=0.0, most=commands.MOST_LIMIT_S)] = 600.0
    env: Annotated[Mapping[str, commands.Word], Size()] = field(default_factory=dict)
    seams: Annotated[tuple[str, ...], Size()] = ()

    @property
    def many(self) -> bool:
        """Whether its JUnit file tells its tests apart."""
        return any(f"{{{JUNIT}}}" in word.text for word in self.run)


@dataclass(frozen=True)
class Suite:
    """A suite of one's own tests.

    Attributes:
        tests: the commands by name.
        folder: where they run, below the folder of the suite's file.
        relays: relays between two topics of the tested system, by the seam whose faults they carry.
        clock: the topic on which the tested system tells its time; left out: by the stamps of messages.
        place: the file.
    """

    tests: Annotated[Mapping[str, SuiteCommand], Size(1, MOST, "a test, at least")]
    folder: str = "."
    relays: Annotated[Mapping[str, commands.Relay], Size()] = field(default_factory=dict)
    clock: commands.ClockTopic | None = None
    place: Annotated[str, Given(lambda item: item.place)] = ""

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a name that cannot stand in the name of a run."""
        for name in self.tests:
            if "/" in name or name != name.strip() or not name.isprintable():
                yield item.need("tests").need(name).error("under a name without '/'")


class Colour(StrEnum):
    """What a run says of a test."""

    GREEN = "green"
    RED = "red"
    SKIPPED = "skipped"
    UNKNOWN = "unknown"


class Result(NamedTuple):
    """What a run says of a test, and why."""

    colour: Colour
    why: str = ""


@dataclass(frozen=True)
class Ran:
    """One run of a command.

    Attributes:
        results: by name of the test; empty where the run says nothing of any.
        why: the reason of an empty one.
        counts: samples carried and altered, by seam.
    """

    results: Mapping[str, Result]
    why: str
    counts: Mapping[str, SeamCount]

    def of(self, test: str) -> Result:
        """What the run says of a test."""
        return self.results.get(test) or Result(Colour.UNKNOWN, self.why or f"the run has no test {test!r}")


def digest_of_inputs(command: SuiteCommand, folder: Path) -> str:
    """A hash of the declared inputs of a command, by content.

    Raises:
        InputError: one is not there.
    """
    parts = []
    for name in command.inputs:
        path = folder / name
        if not is_there(path):
            raise InputError(f"{command.run[0].place}: inputs: there is no {name!r} in {folder}")
        files = sorted(one for one in path.rglob("*") if is_file(one)) if is_folder(path) else [path]
        names = {one.relative_to(folder).as_posix(): one for one in files}
        # what Python and tools leave beside the tests decides nothing
        parts += [[name, digest(one)] for name, one in names.items() if "/." not in name and "__pycache__" not in name]
    return sha256(json.dumps(parts).encode()).hexdigest()


def run_tests(
    suite: Suite, name: str, folder: Path, mutant: Mutant | None, seed: int, stack: Declaration, wire: Wire
) -> Ran:
    """Run a command of a suite once.

    Args:
        suite: the suite.
        name: of the command.
        folder: where it runs.
        mutant: the fault; None = none.
        seed: number of the run.
        stack: declares the seams.
        wire: carries the samples of relays, with the fault.

    Raises:
        BorderError: a relay cannot be opened, or cannot carry what comes.
        InputError: a word has a place for a value that there is not.
    """
    command = suite.tests[name]
    own = mutant is not None and bool(command.seams) and mutant.seam in (*command.seams, EVERY_SEAM)
    with closing(FlightFolder()) as made:
        private, beside = made.path / "run", made.path / "beside"
        private.mkdir()
        beside.mkdir()
        junit, reached = private / "junit.xml", private / "reached.jsonl"
        values: dict[str, Any] = {
            commands.PYTHON: sys.executable,
            JUNIT: str(junit),
            commands.FLIGHT_FOLDER: str(private),
            commands.SEED: seed,
            MUTANT: mutant.id if mutant else "",
            commands.FAULT: json.dumps(mutant.to_json() if mutant is not None and own else None, sort_keys=True),
        }
        words = [word.filled(values) for word in command.run]
        env = {key: text.filled(values) for key, text in command.env.items()}
        env |= {INJECTED: "" if mutant is None else mutant.id, REACHED: str(reached)}
        relays = commands.Relays(suite.relays, stack, wire, beside, suite.clock)
        try:
            env |= relays.begin()
            attend = relays.attend if suite.relays else None
            how, lines = commands.finished(words, env, folder, command.limit_s, beside, attend, made.lifeline)
        except BorderError as error:
            if suite.relays:
                raise
            how, lines = str(error), []
        finally:
            relays.close()
        counts, failed = _reached(reached)
        counts |= {seam: count for seam, count in getattr(wire, "counts", {}).items() if seam in suite.relays}
        said = commands.Told()
        try:
            said = commands.told("".join(lines[-1:])) if own else said
        except commands.CommandError as error:
            failed = failed or str(error)
        if mutant is not None and said.altered is not None:
            counts[mutant.seam] = SeamCount(max(said.carried or 0, said.altered), said.altered, said.first_altered_s)
        results, why = ({}, failed) if failed else _results(name, command, how, junit, commands.said_last(lines))
        if results and own and mutant is not None and mutant.seam not in (*counts, EVERY_SEAM):
            return Ran(
                {},
                f'it ends without a last line {{"altered": COUNT}}, so nobody knows what {mutant.id} altered',
                counts,
            )
        return Ran(results, why, counts)


def _results(name: str, command: SuiteCommand, how: str, junit: Path, said: str) -> tuple[Mapping[str, Result], str]:
    ends = {DONE: Colour.GREEN, **{f"ended with code {code}": Colour.RED for code in command.red}}
    if how not in ends:
        return {}, f"{how}; it said last: {said}"
    if not command.many:
        return {name: Result(ends[how])}, ""
    if not is_file(junit):
        return {}, f"it wrote no JUnit file to {{{JUNIT}}}; it said last: {said}"
    try:
        return _cases(read_bytes(junit, _JUNIT_BYTES)), ""
    except (ElementTree.ParseError, InputError) as error:
        return {}, f"its JUnit file cannot be read: {error}"


def _cases(content: bytes) -> Mapping[str, Result]:
    """The test cases of a JUnit file; of two with one name the worse counts."""
    found: dict[str, Result] = {}
    order = list(Colour)
    for case in ElementTree.fromstring(content).iter("testcase"):
        last = case.get("classname", "").rpartition(".")[2]
        name = "::".join(filter(None, (last, case.get("name", "")))).replace("/", "_").strip()
        parts = {part.tag: part for part in case}
        for tag, colour in (("error", Colour.UNKNOWN), ("failure", Colour.RED), ("skipped", Colour.SKIPPED)):
            if tag in parts:
                result = Result(colour, (parts[tag].get("message") or tag).partition("\n")[0][:200])
                break
        else:
            result = Result(Colour.GREEN)
        before = found.get(name)
        if before is None or order.index(result.colour) > order.index(before.colour):
            found[name] = result
    return found


@contextmanager
def injecting(subject: str, baseline: str) -> Iterator[tuple[str, Callable[[Mapping[str, SeamCount]], None]]]:
    """The subject that a flight of a test flies, and what it tells of its seams; a failure of the flight is told too.

    Args:
        subject: what the test asks for.
        baseline: the subject that becomes the fault which the environment names.
    """
    fault, path = os.environ.get(INJECTED), os.environ.get(REACHED)

    def tell(entry: Mapping[str, Any]) -> None:
        if path:
            with Path(path).open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")

    try:
        yield fault if fault and subject == baseline else subject, tell
    except Exception as error:  # a flight that fails in the harness is no red test
        tell({"failed": in_one_line(error)})
        raise


def _reached(path: Path) -> tuple[dict[str, SeamCount], str]:
    """What all flights of a run altered, by seam, and why one could not be flown."""
    counts: dict[str, SeamCount] = {}
    for line in read_text(path).splitlines() if is_file(path) else ():
        entry: Mapping[str, Any] = json.loads(line)
        if "failed" in entry:
            return counts, str(entry["failed"])
        for seam, (carried, altered, first_s) in entry.items():
            before = counts.get(seam, SeamCount(0, 0, None))
            firsts = [one for one in (before.first_altered_s, first_s) if one is not None]
            counts[seam] = SeamCount(before.carried + carried, before.altered + altered, min(firsts, default=None))
    return counts, ""
