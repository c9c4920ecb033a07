"""One round in a process of its own, and what may go wrong in it."""

import pytest

from harness_plugins.bench.contests import Entry, Round, Setting
from harness_plugins.bench.measure import LeftOut, TimeContest, time_contest
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
