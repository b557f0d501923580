from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from scaloft_fi.campaign.processes import HANGUP
from scaloft_fi.campaign.workers.local import ECHO_S, Flag, interruptible


@pytest.fixture
def hangup() -> Iterator[signal.Signals]:
    """The signal of a terminal that closes; its handler is put back."""
    if not HANGUP:
        pytest.skip("this system has no SIGHUP")
    before = signal.getsignal(HANGUP[0])
    yield HANGUP[0]
    signal.signal(HANGUP[0], before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, *HANGUP])
def test_the_first_signal_asks_to_stop_and_the_handlers_come_back(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    stopped = Flag()
    with interruptible(stopped):
        assert not stopped()
        signal.raise_signal(number)
        assert stopped()
    assert signal.getsignal(number) == before


def test_what_nohup_ignores_stays_ignored(hangup: signal.Signals) -> None:
    signal.signal(hangup, signal.SIG_IGN)
    stopped = Flag()
    with interruptible(stopped):
        signal.raise_signal(hangup)
        assert not stopped()
    assert signal.getsignal(hangup) == signal.SIG_IGN


def test_the_second_signal_does_what_it_did_before_and_an_echo_of_the_first_does_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s = 100.0
    monkeypatch.setattr("scaloft_fi.campaign.workers.local.time.monotonic", lambda: now_s)
    stopped = Flag()
    with interruptible(stopped):
        signal.raise_signal(signal.SIGINT)
        now_s += ECHO_S / 2
        signal.raise_signal(signal.SIGINT)
        now_s += ECHO_S
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
