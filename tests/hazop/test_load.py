from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import CellStatus

GUIDEWORDS = "LATE: {title: LATE, meaning: after its time}\nMORE: {title: MORE, meaning: larger}\n"
PARAMETERS = "human: {title: person detection, intent: seen, node: detector -> limit, unit: boxes}\n"
MORE = "MORE: {status: not_meaningful, reason: none here}\n"
LATE = """LATE:
  status: credible
  deviation: late
  causes: [slow]
  effect: slow late
  requirements: [SR2]
  faults:
    - seam: person
      operator: delay
      magnitude: {argument: delay_s, unit: s, ladder: [1, 3], default: 3}
"""
FAULTS = LATE.splitlines()[6]


def study(folder: Path, human: str = LATE + MORE, guidewords: str = GUIDEWORDS, parameters: str = PARAMETERS) -> Path:
    (folder / "matrix").mkdir()
    (folder / "guidewords.yaml").write_text(guidewords)
    (folder / "parameters.yaml").write_text(parameters)
    (folder / "matrix" / "human.yaml").write_text(human)
    return folder


def with_magnitude(magnitude: str) -> str:
    return LATE.replace("{argument: delay_s, unit: s, ladder: [1, 3], default: 3}", magnitude) + MORE


def test_a_small_study_loads_with_the_places_of_its_faults(tmp_path: Path) -> None:
    matrix = load_matrix(study(tmp_path))
    fault = matrix.cell("LATE-human").faults[0]
    assert matrix.cell("MORE-human").status is CellStatus.NOT_MEANINGFUL
    assert fault.place_of("operator") == f"{tmp_path}/matrix/human.yaml:9"
    assert fault.place_of("delay_s") == f"{tmp_path}/matrix/human.yaml:10"
    assert matrix.cell("LATE-human").requirements_place == f"{tmp_path}/matrix/human.yaml:6"


BAD_CELLS = [
    ("a blank cell", LATE, "human.yaml:", "the cell MORE-human is blank; it must be credible"),
    ("an empty cell", LATE + "MORE:\n", "human.yaml:11:", "the cell MORE-human is blank"),
    (
        "an unknown guideword",
        LATE + MORE + "LATER: {}\n",
        "human.yaml:12:",
        "'LATER' is not a guideword; did you mean 'LATE'?",
    ),
    (
        "an unknown status",
        LATE + "MORE: {status: credibel}\n",
        "human.yaml:11:",
        "status='credibel' is not known; did you mean 'credible'?",
    ),
    ("a reason left out", LATE + "MORE: {status: not_meaningful}\n", "human.yaml:11:", "lacks the key 'reason'"),
    (
        "an empty reason",
        LATE + "MORE: {status: not_meaningful, reason: ''}\n",
        "human.yaml:11:",
        "reason='' must be a text",
    ),
    (
        "a deviation that is not meaningful",
        LATE + "MORE: {status: not_meaningful, reason: none, effect: x}\n",
        "human.yaml:11:",
        "unknown key 'effect' in MORE",
    ),
    (
        "an unknown key",
        LATE.replace("effect:", "efect:") + MORE,
        "human.yaml:",
        "unknown key 'efect' in LATE; did you mean 'effect'?",
    ),
    (
        "a key too many",
        LATE.replace("  effect", "  likelihood: 3\n  effect") + MORE,
        "human.yaml:5:",
        "unknown key 'likelihood'",
    ),
    ("no cause", LATE.replace("[slow]", "[]") + MORE, "human.yaml:4:", "causes=[...] must be a list of at least one"),
    (
        "one requirement without a list",
        LATE.replace("[SR2]", "SR2") + MORE,
        "human.yaml:6:",
        "requirements='SR2' must be a list",
    ),
    (
        "an unknown key of a fault",
        LATE.replace("operator:", "operater:") + MORE,
        "human.yaml:9:",
        "unknown key 'operater' in faults[0]; did you mean 'operator'?",
    ),
    (
        "a ladder that is a number",
        with_magnitude("{argument: delay_s, unit: s, ladder: 3, default: 3}"),
        "human.yaml:10:",
        "ladder=3 must be a list",
    ),
    (
        "an empty ladder",
        with_magnitude("{argument: delay_s, unit: s, ladder: [], default: 3}"),
        "human.yaml:10:",
        "a list of at least one",
    ),
    (
        "a default off the ladder",
        with_magnitude("{argument: delay_s, unit: s, ladder: [1, 2], default: 3}"),
        "human.yaml:10:",
        "default=3 must be on the ladder: 1, 2",
    ),
    (
        "a ladder that repeats",
        with_magnitude("{argument: delay_s, unit: s, ladder: [1, 1.0], default: 1}"),
        "human.yaml:10:",
        "must be different magnitudes",
    ),
    (
        "a ladder of numbers and names",
        with_magnitude("{argument: delay_s, unit: s, ladder: [1, x], default: 1}"),
        "human.yaml:10:",
        "all numbers or all names",
    ),
    (
        "a truth value on the ladder",
        with_magnitude("{argument: delay_s, unit: s, ladder: [yes], default: 1}"),
        "human.yaml:10:",
        "ladder[0]=True must be a number",
    ),
    (
        "a name with a slash",
        with_magnitude("{argument: axis, ladder: [x/y], default: x/y}"),
        "human.yaml:10:",
        "a name of letters",
    ),
    (
        "a unit of a name",
        with_magnitude("{argument: axis, unit: m, ladder: [x], default: x}"),
        "human.yaml:10:",
        "unit='m' must be left out where the ladder holds names",
    ),
    (
        "a unit with a slash",
        with_magnitude("{argument: v, unit: m/s, ladder: [1], default: 1}"),
        "human.yaml:10:",
        "unit='m/s' must be a unit of letters",
    ),
    (
        "a direction that is none",
        with_magnitude("{argument: v, unit: m, worse: lager, ladder: [1, 2], default: 1}"),
        "human.yaml:10:",
        "worse='lager' is not known; did you mean 'larger'?",
    ),
    (
        "a direction of names",
        with_magnitude("{argument: axis, worse: larger, ladder: [x], default: x}"),
        "human.yaml:10:",
        "worse='larger' must be left out where the ladder holds names",
    ),
    (
        "a neutral magnitude without an order",
        with_magnitude("{argument: v, unit: m, worse: unordered, neutral: 1, ladder: [1, 2], default: 1}"),
        "human.yaml:10:",
        "neutral=1 must be left out where the ladder has no order",
    ),
    (
        "a scale of zero",
        with_magnitude("{argument: v, unit: m, scale: 0, ladder: [1], default: 1}"),
        "human.yaml:10:",
        "scale=0 must be a finite number other than 0",
    ),
    (
        "a scale of a name",
        with_magnitude("{argument: axis, scale: 2, ladder: [x], default: x}"),
        "human.yaml:10:",
        "scale=2 must be left out",
    ),
    (
        "a fixed argument that varies",
        LATE.replace("      magnitude", "      arguments: {delay_s: 1}\n      magnitude") + MORE,
        "human.yaml:10:",
        "'delay_s' is set by the magnitude",
    ),
    (
        "a list as argument",
        LATE.replace("      magnitude", "      arguments: {axes: [1, 2]}\n      magnitude") + MORE,
        "human.yaml:10:",
        "must be a number",
    ),
    ("phases that are no flag", LATE + "      phases: 4\n" + MORE, "human.yaml:11:", "phases=4 must be true or false"),
    ("phases of nothing", LATE + "      phases: true\n" + MORE, "human.yaml:8:", "must have its period_s or at_s"),
    (
        "an expectation that is another",
        LATE + "      expected: {status: survived, reason: x}\n" + MORE,
        "human.yaml:11:",
        "status='survived' is not known",
    ),
    (
        "an expectation without reason",
        LATE + "      expected: {status: not_infected}\n" + MORE,
        "human.yaml:11:",
        "lacks the key 'reason'",
    ),
    (
        "an expectation off the ladder",
        LATE + "      expected: {status: not_infected, reason: x, magnitudes: [2]}\n" + MORE,
        "human.yaml:11:",
        "magnitudes: 2 must be on the ladder: 1, 3",
    ),
    ("two faults in one unit", LATE + LATE.split("faults:\n")[1] + MORE, "human.yaml:11:", "a unit of its own"),
    (
        "a second fault without magnitude",
        LATE + "    - {seam: person, operator: drop}\n" + MORE,
        "human.yaml:11:",
        "a unit of its own",
    ),
    ("a syntax error", LATE + MORE + "EARLY: {status: [\n", "human.yaml:", "not valid YAML"),
    ("a cell that stands twice", LATE + MORE + MORE, "human.yaml:12:", "key 'MORE' occurs twice"),
]


@pytest.mark.parametrize(
    ("text", "place", "sentence"), [case[1:] for case in BAD_CELLS], ids=[case[0] for case in BAD_CELLS]
)
def test_a_bad_cell_is_refused_with_file_and_line(tmp_path: Path, text: str, place: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        load_matrix(study(tmp_path, human=text))
    assert place in str(caught.value)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


BAD_LISTS = [
    (
        "a guideword in small letters",
        {"guidewords": "late: {title: LATE, meaning: x}\n"},
        "guidewords.yaml:1: name 'late' must be capital letters",
    ),
    (
        "a guideword without meaning",
        {"guidewords": "LATE: {title: LATE}\n"},
        "guidewords.yaml:1: LATE lacks the key 'meaning'",
    ),
    (
        "an extension without reason",
        {"guidewords": "LATE: {title: LATE, meaning: x, extension: true}\n"},
        "guidewords.yaml:1: LATE lacks the key 'reason'",
    ),
    (
        "a guideword's unknown key",
        {"guidewords": "LATE: {title: LATE, meaning: x, extention: true}\n"},
        "unknown key 'extention' in LATE; did you mean 'extension'?",
    ),
    (
        "a parameter in capitals",
        {"parameters": "HUMAN: {title: x, intent: x, node: x, unit: x}\n"},
        "parameters.yaml:1: name 'HUMAN' must be small letters",
    ),
    (
        "a parameter without intent",
        {"parameters": "human: {title: x, node: x, unit: x}\n"},
        "parameters.yaml:1: human lacks the key 'intent'",
    ),
    (
        "a parameter without cells",
        {"parameters": PARAMETERS + "imu: {title: x, intent: x, node: x, unit: x}\n"},
        "parameters.yaml:2: parameter 'imu' has no cells",
    ),
    (
        "cells of no parameter",
        {"parameters": PARAMETERS.replace("human", "humans")},
        "human.yaml:1: 'human' is not a parameter; did you mean 'humans'?",
    ),
]


@pytest.mark.parametrize(("files", "sentence"), [case[1:] for case in BAD_LISTS], ids=[case[0] for case in BAD_LISTS])
def test_a_bad_guideword_or_parameter_is_refused(tmp_path: Path, files: dict[str, str], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        load_matrix(study(tmp_path, **files))
    assert sentence in str(caught.value)


def test_an_unknown_seam_is_refused_where_the_seams_are_given(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"human.yaml:8: seam='person' is not known; did you mean 'persons'\?"):
        load_matrix(study(tmp_path), seams=("persons", "depth"))


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"guidewords.yaml: cannot be read"):
        load_matrix(tmp_path)
