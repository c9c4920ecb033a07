"""Every entry, several rounds, each in a process of its own, and what may go wrong in it."""

import pytest

from harness.errors import UsageError
from harness_plugins.bench.contests import Entry, Round, Setting
from harness_plugins.bench.measure import LeftOut, TimeContest, measure_speeds, plan_entries, time_contest
from harness_plugins.bench.timed_cell import Failed

SETTING = Setting(budget=0.01)
HOOKS = """
import harness
@harness.hookimpl
def register_simulators(register):
    register("broken", __name__ + "_arm:Broken", summary="raises")
"""
BROKEN = """
from dataclasses import dataclass
@dataclass(frozen=True)
class Broken:
    def open(self, *_):
        1 / 0
"""


@pytest.mark.usefixtures("toys")
def test_a_process_leaves_its_round(tmp_path):
    """And nothing else; a simulator that names no bare engine has no speeds."""
    work = TimeContest(Entry("simulators", "simulators", "ideal", 2), SETTING)
    found = time_contest(work, tmp_path / "timing")
    assert isinstance(found, Round)
    assert set(found.seconds) == {"simulator", "env"}
    assert 0.0 < found.seconds["simulator"] < found.seconds["env"]
    assert found.speeds == {}
    assert list(tmp_path.iterdir()) == []


def test_an_order_is_the_same_on_the_other_side():
    """As JSON."""
    work = TimeContest(Entry("peers", "algorithms", "sac-fast", peer="sbx"), Setting(robot="fd100", steps=9))
    assert TimeContest.from_json(work.to_json()) == work


def test_what_a_plugin_raises_is_a_failure_with_its_reason(install):
    """Whatever it is: it costs this entry alone."""
    install("broken-arm", HOOKS, arm=BROKEN)
    told = TimeContest(Entry("simulators", "simulators", "broken"), SETTING).turns()
    assert told == {"failed": "ZeroDivisionError: division by zero"}


def test_what_cannot_be_done_here_is_left_out(monkeypatch):
    """A usage error says why; nothing is wrong with the plugin."""
    monkeypatch.setattr("harness_plugins.peer_trainings.find_spec", lambda name: None)
    told = TimeContest(Entry("peers", "algorithms", "sac-fast", peer="sbx"), SETTING).turns()
    assert told == {"left out": "sbx is not installed: pip install sbx-rl"}


def test_a_process_that_dies_is_a_failure(tmp_path, monkeypatch):
    """The reason is that of the process."""
    from harness.experiment.workers.workers import News

    monkeypatch.setattr(
        "harness_plugins.bench.measure.run_orders",
        lambda orders, at_once, on_news: on_news(News("ended", orders[0].folder, reason="ended by SIGKILL")),
    )
    work = TimeContest(Entry("simulators", "simulators", "kinematic"), SETTING)
    found = time_contest(work, tmp_path / "timing")
    assert found == Failed("ended by SIGKILL")
    assert not isinstance(found, LeftOut)


A, B, C = (Entry("simulators", "simulators", name) for name in ("kinematic", "ideal", "stuck"))


@pytest.fixture
def timed(monkeypatch):
    """What was timed, in order, and what came of it; no process is started."""
    order, outcomes = [], {}

    def pretend(work, folder):
        order.append(work.entry)
        return outcomes.get(work.entry, Round({"bare engine": 1.0, "env": 2.0}, {"env": 0.5}))

    monkeypatch.setattr("harness_plugins.bench.measure.time_contest", pretend)
    return order, outcomes


def _measure(toys, entries, rounds=2, left_out=()):
    told = []
    return measure_speeds(toys, entries, left_out, Setting(), rounds, lambda *news: told.append(news)), told


def test_entries_take_turns_and_are_told(timed, toys):
    """A slow minute meets all of them; each has as many rounds."""
    found, told = _measure(toys, [A, B])
    assert timed[0] == [A, B, A, B]
    assert [len(speed.rounds) for speed in found.speeds] == [2, 2]
    assert told == [(1, 4, A.title), (2, 4, B.title), (3, 4, A.title), (4, 4, B.title)]


def test_what_fails_or_cannot_be_is_not_tried_again(timed, toys):
    """The others go on; one is a failure, the other is not."""
    timed[1].update({B: Failed("it broke"), C: LeftOut("no memory")})
    found, _ = _measure(toys, [A, B, C], left_out=[("before", "not installed")])
    assert timed[0] == [A, B, C, A]
    assert found.failed == ((B.title, "it broke"),)
    assert found.left_out == (("before", "not installed"), (C.title, "no memory"))
    assert [speed.entry for speed in found.speeds] == [A]


def test_versions_are_those_behind_the_plugins(timed, toys):
    """Python's too: all of them decide how fast it is."""
    found, _ = _measure(toys, [A, B])
    assert {"python", "numpy", "toy-arm"} <= set(found.versions)


def test_simulators_have_an_entry_for_each_size(toys):
    """Those that were named, in that order."""
    entries, left_out = plan_entries(toys, ["simulators"], ["stuck,ideal"], [], (1, 8))
    told = [(entry.name, entry.num_envs) for entry in entries]
    assert told == [("stuck", 1), ("stuck", 8), ("ideal", 1), ("ideal", 8)]
    assert left_out == []


def test_algorithms_that_do_not_learn_are_no_entry(toys):
    """There is no update to time."""
    entries, _ = plan_entries(toys, ["algorithms"], [], ["random", "ik", "sweep"], (1,))
    assert [entry.name for entry in entries] == ["sweep"]


def test_an_algorithm_that_needs_goals_is_left_out_and_told(toys):
    """The task that is timed has none that steps could be paid again for."""
    entries, left_out = plan_entries(toys, ["algorithms"], [], ["her", "sweep"], (1,))
    assert [entry.name for entry in entries] == ["sweep"]
    assert [(name, "other goals" in reason) for name, reason in left_out] == [("her", True)]


def test_peers_are_those_that_plugins_name(toys):
    """Of simulators and of algorithms."""
    entries, _ = plan_entries(toys, ["peers"], ["mujoco", "ideal"], ["sac-fast", "random"], (1,))
    told = [(entry.of, entry.name, entry.peer) for entry in entries]
    assert told == [
        ("simulators", "mujoco", "PandaReach"),
        ("simulators", "mujoco", "FetchReach"),
        ("algorithms", "sac-fast", "stable-baselines3"),
        ("algorithms", "sac-fast", "sbx"),
    ]


@pytest.mark.usefixtures("distant")
def test_what_is_not_installed_is_left_out_unless_it_was_named():
    """With what brings it."""
    from harness.registry.registry import load_registry

    registry = load_registry()
    _, left_out = plan_entries(registry, ["simulators"], [], [], (1,))
    assert ("distant", "Simulator 'distant' needs no_such_engine: pip install 'far-away[engine]'") in left_out
    with pytest.raises(UsageError, match="no_such_engine"):
        plan_entries(registry, ["simulators"], ["distant"], [], (1,))
