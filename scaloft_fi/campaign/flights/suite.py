"""One's own tests as a study: a test stands where a situation stands, a run of it where a seed does.

So plan, store, gates, score and every verb that reads a campaign treat tests as they treat flights.  The one
requirement is that the test is green.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from scaloft_fi.campaign.flights.fly import Batch, Flight, facts, invalid
from scaloft_fi.document import parsed
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Reading, Requirement
from scaloft_fi.judge.space import Realisation
from scaloft_fi.model import read
from scaloft_fi.mutants.mutant import EVERY_SEAM, PLACEBO, Mutant
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.outside.command import runs
from scaloft_fi.outside.suite import Colour, Ran, Suite, digest_of_inputs, run_tests
from scaloft_fi.sim.grid import Grid
from scaloft_fi.sim.situation import Axis, AxisValue, Situation
from scaloft_fi.stack.declaration import Declaration, PlainWire, Wire
from scaloft_fi.study import NO_FINDS, KnownFinds, Study

TEST = "Test"
GREEN = Requirement("green", Kind.SAFETY, "always(green > 0)", title="The test is green.")
"""What every test is judged by."""


@dataclass(frozen=True)
class Looked:
    """What a first run of a command, with PLACEBO, has told.

    Attributes:
        tests: names of its tests, in its order.
        carried: samples that each seam carried; a fault of another seam does not reach its tests.
        wall_s: how long it took [s, wall].
    """

    tests: tuple[str, ...]
    carried: Mapping[str, int]
    wall_s: float


class Tests(Grid):
    """The tests of a suite as a grid of one axis."""

    __test__ = False
    of_tests = True

    def miss(self, name: str) -> str:
        """The error message for a name without a test."""
        return f"no test {name!r}{did_you_mean(name, self.by_key)}"


@dataclass(frozen=True)
class SuiteStudy(Study):
    """A study whose faults are put to one's own tests.

    Attributes:
        file: the suite's file.
        text: its content.
        looked: what the first run of each command has told.
    """

    file: Path = Path()
    text: str = ""
    looked: Mapping[str, Looked] = field(default_factory=dict)

    @cached_property
    def base(self) -> Study:
        """The study of the drone."""
        return Study(self.folder, None, self.archived_name)

    @cached_property
    def suite(self) -> Suite:
        """What the file declares.

        Raises:
            InputError: a key is unknown or a value is not allowed.
        """
        return read(Suite, parsed(self.text, self.file))

    @property
    def tests_of(self) -> str:
        """The suite's file."""
        return str(self.file)

    @property
    def place(self) -> Path:
        """Where the commands run."""
        return self.file.parent / self.suite.folder

    @cached_property
    def command_of(self) -> Mapping[str, str]:
        """The name of the command of each test."""
        return {test: name for name, looked in self.looked.items() for test in looked.tests}

    def reaches(self, mutant: Mutant, test: str) -> bool:
        """Whether a fault can reach a test: its seam carried samples when the test ran, or the command injects it."""
        name = self.command_of[test]
        own = {*self.looked[name].carried, *self.suite.tests[name].seams}
        return mutant.seam == EVERY_SEAM or mutant.seam in own

    @cached_property
    def command(self) -> None:
        """No command of `sim/flyer.yaml` flies."""
        return

    @cached_property
    def stack(self) -> Declaration:
        """The stack; nobody promises that a test has the same result twice."""
        return replace(self.base.stack, deterministic=False)

    @cached_property
    def grid(self) -> Grid:
        """The tests."""
        values = tuple(AxisValue(number, test) for number, test in enumerate(self.command_of))
        listed = tuple(Situation(value.title, ((TEST, value.id),)) for value in values)
        axis = Axis(TEST, "test", "tests of the team", values)
        return Tests((axis,), {}, self.base.grid.documents, name=self.file.name, further=True, listed=listed)

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """That the test is green."""
        return (GREEN,)

    @cached_property
    def realisation(self) -> Realisation:
        """A test is always what its name says."""
        return Realisation.read(self.grid, ())

    @cached_property
    def finds(self) -> KnownFinds:
        """A search finds situations, and no tests."""
        return NO_FINDS

    @property
    def flying_modules(self) -> tuple[str, ...]:
        """The modules that fly, and those that run tests."""
        return *self.base.flying_modules, __name__

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """Hashes as of every study; its situations and requirements count, because tests fly them."""
        own, rest = super().inputs, parsed(self.text, self.file).plain()
        shared = [own["sim"], self.base.inputs["requirements"], {key: rest[key] for key in rest if key != "tests"}]
        return {**own, "sim": hashlib.sha256(json.dumps(shared, sort_keys=True).encode()).hexdigest()}

    def runner(self, situation: Situation) -> str:
        """The command of the test."""
        return self.command_of[situation.key]

    @property
    def most_wall_s(self) -> float:
        """Longest time of a command [s]."""
        return max(command.limit_s for command in self.suite.tests.values())

    def expected_s(self, situation: Situation) -> float:
        """Expected time of the test [s]."""
        looked = self.looked[self.runner(situation)]
        return looked.wall_s / len(looked.tests)

    def limit_s(self, situation: Situation) -> float:
        """Longest time of a run of the test [s]."""
        return self.suite.tests[self.runner(situation)].limit_s

    def changes(self, situation: Situation) -> dict[str, Any]:
        """What decides the test: its command, and the content of its inputs."""
        name = self.runner(situation)
        entry = parsed(self.text, self.file).plain()["tests"][name]
        return {"command": entry, "inputs": self._digests[name]}

    @cached_property
    def _digests(self) -> Mapping[str, str]:
        gone = self.archived_name and not self.file.exists()  # an archive has no tests, and its runs count without them
        return {name: "" if gone else digest_of_inputs(one, self.place) for name, one in self.suite.tests.items()}

    def check(self, situations: Iterable[Situation] | None = None) -> None:
        """Read every part that a run of tests needs.

        Raises:
            InputError: a part is wrong.
        """
        _ = self.catalogue, self.suite, self._digests
        for seam in (*self.suite.relays, *(seam for one in self.suite.tests.values() for seam in one.seams)):
            if seam not in self.stack.by_name:
                raise InputError(f"{self.file}: no seam {seam!r}{did_you_mean(seam, self.stack.by_name)}")

    def run(self, name: str, mutant: Mutant | None, test: str, seed: int) -> Ran:
        """Run a command once, with a fault or without.

        Raises:
            BorderError: a relay cannot be opened, or cannot carry what comes.
            InputError: a word of the command has a place for a value that there is not.
        """
        wire: Wire = PlainWire()
        if self.suite.relays and mutant is not None:
            known = facts(self.base.scenario(self.base.grid.situations[0]), self.base.sim.stack.parameters)
            wire = wire_for(mutant, self.stack, contexts(mutant.id, test, seed, known))
        return run_tests(self.suite, name, self.place, mutant, seed, self.stack, wire)

    def look(self, commands: Iterable[str], clock: Callable[[], float]) -> SuiteStudy:
        """Run some commands once with PLACEBO: which tests they have, and which seams carry samples.

        Raises:
            BorderError: as `run`.
            InputError: as `run`, a command says nothing, or two commands have a test of one name.
        """
        looked: dict[str, Looked] = {}
        for name in commands:
            began_s = clock()
            ran = self.run(name, PLACEBO, name, 0)
            if not ran.results:
                raise InputError(f"{self.suite.tests[name].run[0].place}: the command {name!r} says nothing: {ran.why}")
            carried = {seam: count.carried for seam, count in ran.counts.items() if count.carried}
            looked[name] = Looked(tuple(ran.results), carried, clock() - began_s)
        listed = [test for one in looked.values() for test in one.tests]
        if twice := next((test for test in listed if listed.count(test) > 1), None):
            raise InputError(
                f"{self.file}: two commands have a test {twice!r}; only names that differ can be told apart"
            )
        return replace(self, looked=looked)

    def noted(self) -> dict[str, Any]:
        """What a campaign keeps of the suite, in plain JSON values."""
        looked = {name: [list(one.tests), dict(one.carried), one.wall_s] for name, one in self.looked.items()}
        return {"file": str(self.file), "text": self.text, "looked": looked}

    @classmethod
    def of(cls, study: Study, noted: Mapping[str, Any]) -> SuiteStudy:
        """The study with the suite that a campaign keeps.

        Raises:
            KeyError: the note is none.
        """
        looked = {
            str(name): Looked(tuple(map(str, tests)), dict(carried), float(wall_s))
            for name, (tests, carried, wall_s) in noted["looked"].items()
        }
        file, text = Path(str(noted["file"])), str(noted["text"])
        return cls(study.folder, None, study.archived_name, file, text, looked)


class Tester:
    """Runs tests; the flights of one run come one after the other, and the command runs once for them."""

    def __init__(self) -> None:
        self._last: tuple[tuple[str, int, str], Ran] | None = None

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Prove before the first run that the programs are there.

        Raises:
            InputError: one is not.
        """
        assert isinstance(study, SuiteStudy)
        study.check()
        for command in study.suite.tests.values():
            program = command.run[0].text
            if "{" not in program and not runs(program, study.place):
                raise InputError(f"{command.run[0].place}: there is no program {program!r} here that can be run")

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Run the command of a test, unless it has just run for another test, and tell what it says of this one."""
        assert isinstance(study, SuiteStudy)
        test = flight.situation.key
        name = study.command_of[test]
        place = flight.subject.id, flight.seed, name
        if self._last is None or self._last[0] != place:
            self._last = place, study.run(name, flight.mutant, test, flight.seed)
        return outcome_of(flight, self._last[1])

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Nothing is shared: no test forks."""
        raise AssertionError(batch)


def outcome_of(flight: Flight, ran: Ran) -> Outcome:
    """What a run says of a test; where it says nothing, the harness has failed, and nothing is killed."""
    test, mutant = flight.situation.key, flight.mutant
    colour, why = ran.of(test)
    if colour is Colour.UNKNOWN:
        return invalid(flight, why)
    red = colour is Colour.RED
    seam = mutant.seam if mutant and colour is not Colour.SKIPPED else ""  # a skipped test is not put to the test
    counts = [count for name, count in ran.counts.items() if seam in (name, EVERY_SEAM)]
    reading = Reading(
        GREEN.name,
        GREEN.kind,
        -1.0 if red else 1.0,
        0.0 if red else None,
        int(colour is not Colour.SKIPPED),
        open=False,
    )
    return Outcome(
        flight.subject,
        test,
        flight.seed,
        ending=colour,
        readings=(reading,),
        violations=(Violation(GREEN.name, GREEN.kind, 0.0, 0.0, 0.0, 0.0, ""),) if red else (),
        carried=sum(count.carried for count in counts),
        altered=sum(count.altered for count in counts),
        infected_at_s=min((one.first_altered_s for one in counts if one.first_altered_s is not None), default=None),
        # nobody knows whether two runs are the same in more than their colour
        digest=hashlib.sha256(f"{flight.name} {colour}".encode()).hexdigest(),
        realised=((TEST, True),) if mutant is None else (),
    )
