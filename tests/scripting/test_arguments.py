from __future__ import annotations

import inspect

import pytest

from scaloft_fi.campaign.plan import parse_seeds
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.scripting.flight import in_python, number, python_words
from scaloft_fi.scripting.study import OpenCampaign
from scaloft_fi.verbs.options import several


@pytest.mark.parametrize("bad", [0, -1, 100_001, True, 2.5, (), [1, 1], [-1], ["1"], [True], "x", "3-1", {1}])
def test_seeds_that_are_none_are_one_sentence_with_the_name_of_the_argument(bad: object) -> None:
    with pytest.raises(InputError, match="baseline_seeds="):
        parse_seeds(bad, "baseline_seeds")  # type: ignore[arg-type]


def test_one_text_is_one_name() -> None:
    assert several("LATE-human", "mutants") == ("LATE-human",)
    assert several(["a", "b"], "mutants") == ("a", "b")
    with pytest.raises(InputError, match="mutants=3 must be a text"):
        several(["a", 3], "mutants")  # type: ignore[list-item]
    with pytest.raises(InputError, match="mutants=3 must be a text"):
        several(3, "mutants")  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan"), "1", True])
def test_a_number_outside_its_range_is_refused(bad: object) -> None:
    with pytest.raises(InputError, match="max_invalid="):
        number(bad, "max_invalid", 0.0, 1.0)  # type: ignore[arg-type]


def test_an_error_keeps_its_kind_and_names_arguments() -> None:
    with pytest.raises(GateError, match=r"^name another campaign, or `run --campaign NAME`$"), in_python():
        raise GateError("name another --campaign, or `run --campaign NAME`")


def test_a_dash_that_is_no_option_stays() -> None:
    assert python_words("a -- b, LATE-human, x--y, --mutant='a'") == "a -- b, LATE-human, x--y, mutants='a'"


def test_a_method_has_the_texts_and_plain_types_of_the_options_of_its_verb() -> None:
    about, signature = OpenCampaign.kills.__doc__ or "", str(inspect.signature(OpenCampaign.kills))
    assert "    by_requirement: Subsumption tells kills by different requirements of a situation apart.\n" in about
    assert signature.startswith("(self, mutants: 'str | Sequence[str]' = (), situations:")
    assert "those of choose." in (OpenCampaign.run.__doc__ or "")
