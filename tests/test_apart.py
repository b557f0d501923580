"""Files of somebody else are read in a process of their own, whose memory and time are bounded."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi import apart
from scaloft_fi.apart import read_apart
from scaloft_fi.errors import InputError

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="bounds of memory are those of Linux")
HERE = Path(__file__)


@given(st.recursive(st.integers() | st.text() | st.floats(allow_nan=False), st.lists, max_leaves=20))
def test_what_the_work_makes_comes_home_whatever_it_is(made: Any) -> None:
    assert read_apart(HERE, lambda: made) == made


def test_an_error_of_the_work_is_told_as_it_is() -> None:
    def refuse() -> None:
        raise InputError("flight.bag: no")

    with pytest.raises(InputError, match=r"^flight\.bag: no$"):
        read_apart(HERE, refuse)


def test_what_a_library_prints_beside_python_is_not_shown(capfd: pytest.CaptureFixture[str]) -> None:
    assert read_apart(HERE, lambda: os.write(1, b"bad") + os.write(2, b"header")) == 9
    assert capfd.readouterr() == ("", "")


def test_what_unpacks_to_too_much_is_one_sentence() -> None:
    with pytest.raises(InputError, match=r"test_apart\.py: it unpacks to more than 512 MiB"):
        read_apart(HERE, lambda: len(bytearray(2 << 30)))


def test_what_takes_too_long_is_one_sentence_and_leaves_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(apart, "APART_S", 0.3)
    begun: list[int] = []
    fork = os.fork
    monkeypatch.setattr(os, "fork", lambda: begun.append(pid := fork()) or pid)
    with pytest.raises(InputError, match="reading it takes more than 0 s"):
        read_apart(HERE, lambda: time.sleep(60))
    with pytest.raises(ProcessLookupError):
        os.kill(begun[0], 0)


@pytest.mark.parametrize("ended_by", [signal.SIGKILL, signal.SIGABRT])
def test_a_library_that_ends_its_process_ends_not_ours(ended_by: signal.Signals) -> None:
    with pytest.raises(InputError, match="reading it ended its process"):
        read_apart(HERE, lambda: (faulthandler.disable(), os.kill(os.getpid(), ended_by)))


def test_the_bounds_grow_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(apart, "BYTES_A_BYTE", 1 << 20)
    large = tmp_path / "large"
    large.write_bytes(bytes(2_000))
    assert read_apart(large, lambda: len(bytearray(1 << 30))) == 1 << 30
