from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from scaloft_fi.campaign.processes.start import HANGUP
from scaloft_fi.campaign.workers.interrupt import interruptible


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
    with interruptible() as stopped:
        assert not stopped()
        signal.raise_signal(number)
        assert stopped()
    assert signal.getsignal(number) == before


def test_what_nohup_ignores_stays_ignored(hangup: signal.Signals) -> None:
    signal.signal(hangup, signal.SIG_IGN)
    with interruptible() as stopped:
        signal.raise_signal(hangup)
        assert not stopped()
    assert signal.getsignal(hangup) == signal.SIG_IGN
