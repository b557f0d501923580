"""Every screen asks for the same next step."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.survivors import survivors
from scaloft_fi.verbs.verdict import Next, next_command, next_steps, short_step

LATE, STRONGER, HERE = "LATE-human@3s", "LATE-human@5s", "T0O0W0D0H1"
WEAK, LAST = Background("person", ("SR2",), stronger=(STRONGER,), laddered=True), Background("person", ("SR2",))


def _known(outcomes: list[Outcome], background: Background) -> Mapping[str, Background]:
    return dict.fromkeys([flight.mutant for flight in outcomes], background)


@settings(deadline=None, max_examples=usually(25, release=100))
@given(
    st.one_of(campaigns(), seeded()),
    st.sampled_from([WEAK, LAST, Background("person", ("OP1",)), Background("person", expected="declared")]),
)
def test_kills_the_first_screen_and_the_exports_agree(outcomes: list[Outcome], background: Background) -> None:
    scored, known = score(outcomes, ROSTER, GRID), _known(outcomes, background)
    told = survivors(outcomes, scored, kill_matrix(scored, ROSTER, GRID), known, {})
    mutants = {mutant.subject.id: mutant for mutant in scored.mutants}
    for survivor in told:
        mutant = mutants[survivor.mutant]
        steps = next_steps(mutant, scored, known[survivor.mutant])
        assert survivor.next in steps
        assert short_step(mutant, steps, background)
        flies = next_command(mutant, scored.lacking, "c").startswith("scaloft-fi run")
        assert flies == (survivor.next in (Next.POOL, Next.SEEDS))


@pytest.mark.parametrize(("background", "step"), [(WEAK, Next.MAGNITUDE), (LAST, Next.SITUATION)])
def test_more_seeds_are_not_asked_of_a_fault_that_flies_the_same_to_the_bit(background: Background, step: Next) -> None:
    scored = score([*pool(HERE), outcome(LATE, HERE, digest="clean")], ROSTER, GRID)
    (mutant,) = scored.mutants
    assert mutant.safety.needed
    assert next_steps(mutant, scored, background) == (step,)
