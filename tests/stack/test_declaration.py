from __future__ import annotations

import pytest
from tiny_stack import SOUND, hop


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"seams": (*SOUND.seams, SOUND.seams[0])}, "stack 'hop' declares seam 'gyro' twice"),
        ({"beliefs": (*SOUND.beliefs, SOUND.beliefs[1])}, "stack 'hop' declares belief 'doubt' twice"),
        ({"canaries": ("rotors", "propeller")}, "stack 'hop' has no seam 'propeller' for a canary"),
    ],
)
def test_a_declaration_that_contradicts_itself_is_refused(changes, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        hop(**changes)


def test_caps_are_of_the_beliefs_that_declare_a_greatest_value():
    assert SOUND.caps == {"doubt": 1.0}
    assert SOUND.belief_names == ("clock_s", "doubt")
