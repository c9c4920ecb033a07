"""What a run found, kept and read again."""

import json

import pytest

from harness.errors import NewerFormat, SchemaError
from harness_plugins.bench.contests import Entry
from harness_plugins.bench.speeds import Spread, read_speeds, spread_of


def _write(path, found, /, **changed):
    path.write_text(json.dumps({**found.to_json(), **changed}))
    return path


def test_what_is_written_is_read_again(make_speeds, tmp_path):
    """All of it."""
    speeds = make_speeds([0.5, 0.6, 0.7], [2.0, 2.1, 2.2], failed=(("x", "broke"),), left_out=(("y", "missing"),))
    assert read_speeds(_write(tmp_path / "old.json", speeds)) == speeds


def test_json_has_medians_and_middle_halves(make_speeds):
    """Beside every round."""
    [told] = make_speeds([1.0, 2.0, 3.0, 4.0, 5.0]).to_json()["speeds"]
    assert told["speeds"] == {"env": {"median": 3.0, "low": 2.0, "high": 4.0}}
    assert (told["title"], told["reference"]) == ("sim-0, 1 env", "bare engine")
    assert len(told["rounds"]) == 5


def test_the_spread_of_one_round_is_nothing():
    """It is all there is."""
    assert spread_of([0.5]) == Spread(0.5, 0.5, 0.5)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"what": "cells"}, "holds no speeds. Give a file that 'harness bench simulators --json' wrote"),
        ({"speeds": [{"entry": {}, "rounds": []}]}, "is not what the harness wrote: speeds.0"),
        ({"rounds": 0}, "is not what the harness wrote: rounds"),
        ({"cpu": None}, "is not what the harness wrote: cpu"),
    ],
)
def test_what_is_no_run_of_speeds_is_refused(make_speeds, tmp_path, changed, told: str):
    """It says what is wrong, and where."""
    with pytest.raises(SchemaError, match=told):
        read_speeds(_write(tmp_path / "old.json", make_speeds([1.0]), **changed))


@pytest.mark.parametrize("speed", [0.0, -1.0, "fast"])
def test_speeds_that_cannot_be_are_refused(make_speeds, tmp_path, speed):
    """Their logarithms would be taken."""
    data = make_speeds([1.0]).to_json()
    data["speeds"][0]["rounds"][0]["speeds"]["env"] = speed
    path = tmp_path / "old.json"
    path.write_text(json.dumps(data))
    with pytest.raises(SchemaError, match="is not what the harness wrote"):
        read_speeds(path)


def test_a_newer_format_is_refused(make_speeds, tmp_path):
    """It says which one it has."""
    with pytest.raises(NewerFormat, match="has format 9, this version reads 1"):
        read_speeds(_write(tmp_path / "old.json", make_speeds([1.0]), format=9))


def test_what_is_no_json_is_refused(tmp_path):
    """In one line."""
    (tmp_path / "old.json").write_text("fast")
    with pytest.raises(SchemaError, match="is no JSON"):
        read_speeds(tmp_path / "old.json")


@pytest.mark.parametrize(
    ("entry", "title"),
    [
        (Entry("simulators", "simulators", "mujoco"), "mujoco, 1 env"),
        (Entry("simulators", "simulators", "mujoco", 1024), "mujoco, 1,024 envs"),
        (Entry("algorithms", "algorithms", "sac"), "sac"),
        (Entry("peers", "simulators", "mujoco", peer="PandaReach"), "mujoco beside PandaReach"),
    ],
)
def test_titles_tell_entries_apart(entry: Entry, title: str):
    """By plugin, number of envs and peer."""
    assert entry.title == title
