from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from forms import of_form
from printed import no_terms

from scaloft_fi.campaign.flights.command import judged_record, known_of, mapping_of
from scaloft_fi.campaign.flights.fly import fly_log, judged
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.cli import main
from scaloft_fi.study import Study
from scaloft_fi.verbs.replay import log_table, mcap

STUDY = Path(__file__).parents[2]
FLIGHTS = ("LATE-human@3s/T0O0W0D0H1/0", "REVERSE-velcmd/T0O0W0D0H0/0")
COLUMNS = (
    *("elapsed_s", "remaining_s", "x_m", "y_m", "z_m", "speed_mps", "clearance_m", "person_sight_m"),
    *("clearance_person_m", "told_person", "told_range_m", "waypoints_left", "landed"),
)


def judge(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["judge", *map(str, words), "--study", str(STUDY)], catch_exceptions=False)


def a_record(folder: Path, **last: float) -> Path:
    """Two seconds of hovering far from everything, with these values in the last sample."""
    benign = dict.fromkeys(COLUMNS, 0.0) | dict.fromkeys(("clearance_m", "clearance_person_m"), 1.0)
    benign |= {"remaining_s": 50.0, "person_sight_m": 100.0, "waypoints_left": 2.0}
    rows = [benign | {"elapsed_s": i / 20.0} for i in range(41)]
    rows[-1] |= last
    path = folder / "flight.csv"
    path.write_text("\n".join([",".join(COLUMNS), *(",".join(str(row[name]) for name in COLUMNS) for row in rows)]))
    return path


def test_a_violation_is_a_finding_with_time_and_place_and_the_exit_code_is_0(tmp_path: Path) -> None:
    done = judge(a_record(tmp_path, clearance_m=-0.001, x_m=3.5), "--format", "json")
    assert done.exit_code == 0
    rows = {row["requirement"]: row for row in of_form("judge", done.stdout)["readings"]}
    assert (rows["SR1"]["verdict"], rows["SR1"]["violated_at_s"], rows["SR1"]["x"]) == ("violated", 2.0, 3.5)
    assert (rows["SR1"]["robustness"], rows["SR2"]["verdict"], rows["SR2"]["robustness"]) == (-0.001, "open", None)


def test_a_requirement_whose_condition_never_comes_true_is_vacuous(tmp_path: Path) -> None:
    readings = of_form("judge", judge(a_record(tmp_path), "--format", "json").stdout)["readings"]
    verdicts = {one["requirement"]: one["verdict"] for one in readings}
    assert (verdicts["SR1"], verdicts["SR2"]) == ("held", "vacuous")


def test_a_situation_gives_route_and_time_limit_to_a_record_without_them(tmp_path: Path) -> None:
    record = a_record(tmp_path)
    mapping = tmp_path / "own.yaml"
    names = [name for name in COLUMNS if name not in ("elapsed_s", "remaining_s", "waypoints_left")]
    entries = [f"  {name}: {{column: {name}}}" for name in names]
    mapping.write_text("\n".join(["time: {column: elapsed_s}", "signals:", *entries]))
    refused = judge(record, "--record", mapping)
    assert refused.exit_code == 2
    assert "requirement OP1 needs the signal 'remaining_s'" in refused.stderr
    assert refused.stderr.count("\n") == 1
    done = judge(record, "--record", mapping, "--situation", "T0O0W0D0H0", "--format", "markdown")
    assert (done.exit_code, no_terms(done.stdout)) == (0, [])


def test_the_study_names_the_mapping_of_its_records(tmp_path: Path, copy: Path, call: Callable[..., Result]) -> None:
    (copy / "sim" / "record.yaml").write_text("signals: {x_mm: {column: x}}")
    done = CliRunner().invoke(main, ["judge", str(a_record(tmp_path)), "--study", str(copy)], catch_exceptions=False)
    assert done.exit_code == 2
    assert "record.yaml:1: 'x_mm' is no signal that this study knows" in done.stderr


@pytest.mark.flight
@pytest.mark.parametrize("name", FLIGHTS)
def test_a_flight_of_ours_is_judged_from_its_records_as_it_is_judged_directly(name: str, tmp_path: Path) -> None:
    study = Study.open(STUDY)
    mutant, situation, seed = name.split("/")
    flight = flight_named(study, mutant, situation, int(seed))
    log = fly_log(study, flight)
    outcome = judged(study, flight, log)
    assert outcome.violations
    (tmp_path / "flight.csv").write_bytes(log_table(log))
    (tmp_path / "flight.mcap").write_bytes(mcap(log, name))
    known, mapping = known_of(study, flight.situation), mapping_of(study)
    for ending in ("csv", "mcap"):
        record = judged_record(study, tmp_path / f"flight.{ending}", mapping, known)
        assert tuple(finding.reading for finding in record.findings) == outcome.readings
        places = [finding.place for finding in record.findings if finding.place is not None]
        assert places == [(found.x, found.y, found.z) for found in outcome.violations]
        assert (record.log.ending, record.log.struck) == (log.ending, log.struck)
