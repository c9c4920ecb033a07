"""What a run found, kept and read again, and what became slower between two runs."""

import json

import numpy as np
import pytest

from harness.errors import NewerFormat, SchemaError
from harness_plugins.bench.contests import Entry
from harness_plugins.bench.speeds import (
    FALSE_ALARMS,
    Reason,
    Spread,
    compare_speeds,
    described,
    read_speeds,
    spread_of,
    summary,
)


def _write(path, found, /, **changed):
    path.write_text(json.dumps({**found.to_json(), **changed}))
    return path


def test_what_is_written_is_read_again(make_speeds, tmp_path):
    """All of it."""
    failed, left_out = (Reason("x", "broke"),), (Reason("y", "missing"),)
    speeds = make_speeds([0.5, 0.6, 0.7], [2.0, 2.1, 2.2], failed=failed, left_out=left_out)
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
        (Entry("algorithms", "algorithms", "sb3-sac"), "sb3-sac"),
        (Entry("peers", "simulators", "mujoco", peer="PandaReach"), "mujoco beside PandaReach"),
    ],
)
def test_titles_tell_entries_apart(entry: Entry, title: str):
    """By plugin, number of envs and peer."""
    assert entry.title == title


ROUNDS, LINES = 9, 16


def _rows(rng: np.random.Generator, noise: float, factor: float = 1.0) -> np.ndarray:
    """Speeds of every line, (LINES, ROUNDS); the first line is `factor` times as fast as it was."""
    speeds = np.exp(noise * rng.standard_normal((LINES, ROUNDS)))
    speeds[0] *= factor
    return speeds


@pytest.mark.parametrize("noise", [0.005, 0.05, 0.15])
def test_the_same_code_raises_no_alarm(make_speeds, noise: float):
    """200 comparisons, 16 lines each, of a quiet and of a busy machine: at most one has an alarm."""
    rng = np.random.default_rng(0)
    alarms = [
        bool(compare_speeds(make_speeds(*_rows(rng, noise)), make_speeds(*_rows(rng, noise))).slower)
        for _ in range(200)
    ]
    assert sum(alarms) <= 1


def test_lines_share_the_false_alarms(make_speeds):
    """More lines take more to complain of one, so that a long table is not a loud one."""
    rng = np.random.default_rng(1)
    old, new = _rows(rng, 0.1), _rows(rng, 0.1)
    [one] = compare_speeds(make_speeds(old[0]), make_speeds(new[0])).changes
    many = compare_speeds(make_speeds(*old), make_speeds(*new)).changes
    assert many[0].noise < one.noise < 1.0
    assert FALSE_ALARMS <= 1e-3


@pytest.mark.parametrize(("noise", "factor", "at_least"), [(0.015, 1 / 1.15, 99), (0.03, 1 / 1.2, 97)])
def test_a_planted_slowdown_is_found(make_speeds, noise: float, factor: float, at_least: int):
    """15 % on a quiet machine, 20 % on one that does something else; and nothing but the line that became slower."""
    rng = np.random.default_rng(2)
    found = [
        compare_speeds(make_speeds(*_rows(rng, noise)), make_speeds(*_rows(rng, noise, factor))).slower
        for _ in range(100)
    ]
    assert sum([change.title for change in slower] == ["sim-0, 1 env"] for slower in found) >= at_least


def test_a_small_change_is_none_however_small_the_noise(make_speeds):
    """8 % may be what else the machine did; 10 % is more."""
    old = make_speeds([1.0, 1.0001, 0.9999])
    assert not compare_speeds(old, make_speeds([0.92, 0.9201, 0.9199])).slower
    assert compare_speeds(old, make_speeds([0.9, 0.9001, 0.8999])).slower


def test_one_slow_round_is_noise(make_speeds):
    """It makes the noise larger, and is not told as a change."""
    old = make_speeds([1.0, 1.01, 0.99, 1.0, 1.01, 0.99, 1.0])
    assert not compare_speeds(old, make_speeds([1.0, 1.01, 0.3, 1.0, 1.01, 0.99, 1.0])).slower


def test_faster_is_told_and_is_no_alarm(make_speeds):
    """The same rule the other way round."""
    comparison = compare_speeds(make_speeds([1.0, 1.01, 0.99]), make_speeds([2.0, 2.02, 1.98]))
    assert [change.is_faster for change in comparison.changes] == [True]
    assert not comparison.slower
    assert "env is 100% faster" in summary(comparison)[-1]


def test_the_sentence_says_how_much_and_how_sure(make_speeds):
    """By name, beside what, by how much, and what noise would explain."""
    [change] = compare_speeds(make_speeds([1.0, 1.001, 0.999]), make_speeds([0.8, 0.801, 0.799])).slower
    assert described(change) == (
        "sim-0, 1 env: env is 20% slower beside the bare engine than it was (noise explains up to 9%)"
    )


def test_a_faster_machine_makes_no_plugin_faster(make_speeds):
    """Seconds are halved, what is compared is the ratio; and the machine is named."""
    old, new = make_speeds([0.8, 0.81, 0.79]), make_speeds([0.8, 0.81, 0.79], cpu="another", versions={"numpy": "2.1"})
    comparison = compare_speeds(old, new)
    assert comparison.changes[0].ratio == pytest.approx(1.0)
    assert comparison.remarks == (
        "The machines differ: a cpu before, another now. The ratios of two machines differ by themselves.",
        "The versions of numpy differ: 2.0 before, 2.1 now.",
    )


def test_what_only_the_earlier_run_has_is_named(make_speeds):
    """It failed since, or cannot be timed here."""
    comparison = compare_speeds(make_speeds([1.0] * 3, [1.0] * 3), make_speeds([1.0] * 3))
    assert comparison.missing == ("sim-1, 1 env",)
    assert [change.title for change in comparison.changes] == ["sim-0, 1 env"]


def test_too_few_rounds_are_not_judged(make_speeds):
    """Two do not tell how much they differ by themselves."""
    comparison = compare_speeds(make_speeds([1.0, 1.0]), make_speeds([0.1, 0.1]))
    assert (comparison.changes, list(summary(comparison))) == ((), ["Nothing could be compared."])
    assert "does not tell its noise" in comparison.remarks[0]
