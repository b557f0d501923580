"""Strangers on a real scheduler change no outcome, run no code in the run's process, and are told of."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import distributed
import pytest

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.workers.cluster import Cluster, Inbox, fly_batch
from scaloft_fi.campaign.workers.plain import batch_to_plain, flyer_to_plain
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

HUGE_MB = 64
"""A message of 1 GB was tried by hand: the run's process grew by less than 30 MB."""
EVIL = """
import os

FOLDER = {folder!r}

class Evil(Exception):  # its pickle writes the number of the process that reads it
    def __reduce__(self):
        code = f"import os; open(os.path.join({{FOLDER!r}}, str(os.getpid())), 'w').close()"
        return exec, (code,)

class Twice:  # its pickle makes the scheduler hold, and pass on, what is evil
    def __reduce__(self):
        return Evil, ()
"""
WITHOUT_KEY = """
from evil import Evil
from scaloft_fi.campaign.workers import cluster

def join(order, bundle):
    raise Evil

cluster.join = join
"""
LIAR = """
from itertools import count
from scaloft_fi.campaign.workers import cluster

cluster.honest, turn = getattr(cluster, "honest", cluster.outcome_to_plain), count()  # a preload is run twice

def nonsense(outcome):
    right = dict(cluster.honest(outcome))
    wrong_digest = right["row"][:13] + ["f" * 64 + "nonsense"] + right["row"][14:]
    wrong_seed = right["row"][:5] + [right["row"][5] + 1] + right["row"][6:]
    wrong = ["nonsense", {}, right | {"row": wrong_digest}, right | {"row": wrong_seed}, right | {"track": "eA=="}]
    return wrong[next(turn) % len(wrong)]

cluster.outcome_to_plain = nonsense
"""
STRANGER = """
import pickle, sys, time
import distributed
from distributed.protocol import to_serialize
from evil import Evil, Twice
from scaloft_fi.campaign.workers.cluster import Message, sealed, topic_of
from scaloft_fi.campaign.workers.cluster import fly_batch

address, done, huge_mb = sys.argv[1:]
with distributed.Client(f"tcp://{address}", set_as_default=False) as client:
    before = [topic for topic in client.get_events() if topic.startswith("scaloft-fi-")]
    while not before:
        time.sleep(0.05)
        before = [topic for topic in client.get_events() if topic.startswith("scaloft-fi-")]
    topics = [*client.get_events(), "print", "warn", topic_of(b"a key that the stranger made up")]
    pickled = pickle.dumps(Evil())
    forged = sealed(b"a key that the stranger made up", Message("run", 1, "tcp://127.0.0.1:1", 1, "outcome", {}))
    replayed = [event for _, event in client.get_events(before[0])]
    for topic in topics:
        evil = [Evil(), Twice(), to_serialize(Evil()), pickled, {"message": pickled, "category": pickled}]
        for payload in [*evil, None, 1, forged, {"args": ("I am in",)}, "x" * 2_000_000, [[[[]]]] * 1000, *replayed]:
            client.sync(client.scheduler.log_event, topic=topic, msg=payload)
    client.submit(fly_batch, forged, pure=False).exception()
    time.sleep(0.5)  # what follows is a message of its own
    client.log_event(before[0], "x" * (int(huge_mb) << 20))
    client.get_events("print")  # the messages before it have arrived
open(done, "w").close()
"""


class Attacked(NamedTuple):
    """What became of a run among strangers."""

    planned: list[Flight]
    home: list[Outcome]
    said: list[str]
    evil: set[str]
    growth_mb: float


@pytest.fixture(scope="module")
def address(dask: Any, flyer: Any, tmp_path_factory: pytest.TempPathFactory) -> str:
    """A scheduler with a worker of the run, one without the key, and one that has the key and lies."""
    folder = tmp_path_factory.mktemp("strangers")
    (folder / "evil").mkdir()
    for name, text in (
        ("evil.py", EVIL.format(folder=str(folder / "evil"))),
        ("without_key.py", WITHOUT_KEY),
        ("liar.py", LIAR),
        ("stranger.py", STRANGER),
    ):
        (folder / name).write_text(text)
    path = os.pathsep.join([*sys.path, str(folder)])
    address = dask.scheduler(PYTHONPATH=path)
    dask.worker(address, "--no-nanny", "--name", "honest")
    dask.worker(address, "--no-nanny", "--preload", folder / "liar.py", PYTHONPATH=path)
    dask.worker(
        address,
        "--no-nanny",
        "--preload",
        folder / "without_key.py",
        PYTHONPATH=path,
        SCALOFT_CLUSTER_KEY="/no/such/key",
    )
    with distributed.Client(f"tcp://{address}", set_as_default=False) as client:
        client.wait_for_workers(3, timeout=60)
    return str(address)


@pytest.fixture(scope="module")
def attacked(
    address: str, dask: Any, flyer: Any, reference: Study, tmp_path_factory: pytest.TempPathFactory
) -> Attacked:
    """A run that flies while a stranger attacks."""
    folder = Path(str(dask.folder))
    evil = next(tmp_path_factory.getbasetemp().glob("strangers*")) / "evil"
    done = folder / "attacked"
    subjects = [None, realise(reference.matrix, "LATE-human@3s"), realise(reference.matrix, "MORE-goal@1m")]
    batches = [
        Batch(tuple(Flight(subject, situation, 0) for subject in subjects), shared=True)
        for situation in reference.grid.situations[:6]
    ]
    said: list[str] = []
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*sys.path, str(evil.parent)])}
    stranger = subprocess.Popen(
        [sys.executable, str(evil.parent / "stranger.py"), address, str(done), str(HUGE_MB)], env=environment
    )
    with Cluster(address, dask.key).workers(
        reference, flyer(after=str(done)), stop=lambda: stranger.poll() not in (None, 0), say=said.append
    ) as workers:
        home = list(workers.map(batches))
    assert stranger.wait() == 0
    growth_mb = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb) / 1024
    planned = [flight for batch in batches for flight in batch.flights]
    return Attacked(planned, home, said, {path.name for path in evil.iterdir()}, growth_mb)


def test_no_outcome_is_changed_lost_or_repeated(attacked: Attacked) -> None:
    assert sorted(outcome.name for outcome in attacked.home) == sorted(flight.name for flight in attacked.planned)
    assert {(outcome.invalid, outcome.ending, outcome.digest) for outcome in attacked.home} == {
        ("", "landed", "0" * 64)
    }


def test_no_pickle_is_read_in_the_process_of_the_run(attacked: Attacked) -> None:
    assert attacked.evil, "a pickle was read somewhere, so the attack is one"
    assert str(os.getpid()) not in attacked.evil


def test_what_strangers_sent_is_told_once_and_counted_at_the_end(attacked: Attacked) -> None:
    during, *end = [line for line in attacked.said if "on the scheduler" in line]
    assert during == "warning: messages on the scheduler do not carry the key of the run; they are ignored"
    assert len(end) == 1
    count, text = end[0].removeprefix("warning: ").split(" ", 1)
    assert int(count) > 10
    assert text == "messages on the scheduler did not carry the key of the run and were ignored"


def test_a_worker_without_the_key_gets_no_flight_and_is_told(attacked: Attacked) -> None:
    (line,) = [line for line in attacked.said if "did not prove that it has the key" in line]
    assert "start it with SCALOFT_CLUSTER_KEY=FILE and with the same scaloft-fi" in line


def test_a_worker_that_sends_nonsense_gets_no_more_flights_and_is_told(attacked: Attacked) -> None:
    (line,) = [line for line in attacked.said if "sent what is no outcome of its batch" in line]
    assert line.endswith("an outcome has a row and a track")
    (line,) = [line for line in attacked.said if "held no outcome that was asked for" in line]
    assert int(line.split()[1]) >= 3


def test_a_huge_message_is_not_held_in_memory(attacked: Attacked) -> None:
    assert attacked.growth_mb < HUGE_MB / 2


def test_work_without_the_key_or_sent_again_is_not_flown(address: str, dask: Any, flyer: Any, reference: Study) -> None:
    batch = Batch((Flight(None, reference.grid.situations[0], 0),))
    content = {"bundle": "none", "flyer": flyer_to_plain(flyer()), "batch": batch_to_plain(batch)}
    _, order = Inbox(dask.key).order("fly", content)
    _, forged = Inbox(b"another key, which a stranger made up").order("fly", content)
    with distributed.Client(f"tcp://{address}", set_as_default=False) as client:
        refused = client.submit(fly_batch, forged, workers=["honest"], pure=False)
        assert "does not carry the key" in str(refused.exception())
        first = client.submit(fly_batch, order, workers=["honest"], pure=False)
        assert first.exception() is None
        again = client.submit(fly_batch, order, workers=["honest"], pure=False)
        assert "was sent twice" in str(again.exception())
