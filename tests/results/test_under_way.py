"""What a report says of trainings that go on, by the rows that they have written."""

import io
import json
import re
from functools import partial
from itertools import count

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from rich.console import Console

import harness
from harness.cli import main
from harness.cli.progress import LiveProgress
from harness.cli.status import so_far_of
from harness.executor import Event
from harness.record import Store, TraceWriter, partial_folder
from harness.record.cell import Running, write_running
from harness.results import load_results
from harness.results.under_way import so_far
from harness_plugins.watch.recorded import Recording

ARM = {"sim": "ideal", "algo": "wander", "reward": "arp", "task": "fd100-reach:horizon=5"}
CARTPOLE = {"algo": "random", "task": "gymnasium:id=CartPole-v1"}


@pytest.fixture(params=[ARM, CARTPOLE], ids=["arm", "environment"])
def begun(request, toys, tmp_path):
    """An experiment of which a run does one cell: its training has rows, and nothing else; the partial folder too."""
    folder = tmp_path / "it"
    harness.run(**request.param, seeds=2, steps=60, evaluation_episodes=1, executor="here", out=folder)
    store = Store(folder)
    cell = store.read_plan().cells[0]
    ended = store.cell_folder(cell)
    partial = ended.with_name(f".{ended.name}.partial")
    ended.rename(partial)
    (partial / "manifest.json").unlink()
    return cell, partial


def _reason(cell, partial):
    (found,) = [it for it in load_results(partial.parents[1]).manifests if it.cell == cell]
    assert found.status == "pending"
    return found.reason


def test_report_tells_the_rows_that_are_there(begun):
    """How many steps, and what the last episodes came to; the cell counts as pending all the same."""
    cell, partial = begun
    told = _reason(cell, partial)
    assert told.startswith(f"{cell.title}: 60 of 60 steps recorded; its last ")
    assert re.search(r"its last \d+ episodes were paid -?[\d.e+-]+ on average", told)


def test_status_tells_the_same_rows(begun, capsys):
    """What a report says of them, and the numbers for programs."""
    cell, partial = begun
    told, folder = _reason(cell, partial), partial.parents[1]
    write_running(folder, {cell.id: Running(100.0, 6, 103.0)})
    for flags in ([], ["--json"]):
        with pytest.raises(SystemExit):
            main(["status", str(folder), *flags])
    said, _, numbers = capsys.readouterr().out.partition("{")
    assert f"interrupted: {told}; run" in " ".join(said.split())
    (shown,) = [it for it in json.loads(f"{{{numbers}")["cells"] if it["id"] == cell.id]
    assert shown["recorded"] == 60
    assert f"were paid {shown['mean_return']:.4g} on average" in shown["text"]


def test_a_trace_without_rows_tells_that(make_cell, tmp_path):
    """A training has a trace before its first step."""
    cell, store = make_cell(), Store(tmp_path)
    folder = partial_folder(store.cell_folder(cell))
    folder.mkdir(parents=True)
    TraceWriter(folder / "trace.parquet", 2, 2).keep()
    assert so_far(cell, store).text == f"0 of {cell.steps} steps recorded, and no episode has ended"


def test_damaged_rows_are_told(begun):
    """With the file, and no report is stopped by them."""
    cell, partial = begun
    (path, *_) = (*partial.glob("trace.parquet"), *partial.glob("training/recording-0.json"))
    path.write_bytes(b"half")
    assert path.name in _reason(cell, partial)


def test_cell_that_has_recorded_nothing_is_not_run_yet(begun):
    """A partial folder alone tells nothing."""
    cell, partial = begun
    for path in (*partial.glob("trace.parquet"), *partial.glob("training/*")):
        path.unlink()
    assert _reason(cell, partial) == "not run yet"


class _Turns(gymnasium.Env):
    """Episodes of one step: three fail, three succeed, and so on."""

    observation_space, action_space = Box(0.0, 1.0, (1,)), Discrete(2)
    count = 0

    def reset(self, *, seed=None, options=None):
        return np.zeros(1, np.float32), {}

    def step(self, action):
        did, self.count = self.count // 3 % 2, self.count + 1
        return np.zeros(1, np.float32), float(-did if action else did), True, False, {"success": did}


def words(cell, partial_, capsys, action):
    """What each door says of one training that is paid for failing, 1, or for succeeding, 0."""
    folder, store = partial_.parents[1], Store(partial_.parents[1])
    for path in partial_.glob("training/*"):
        path.unlink()
    name = cell.reward.label
    given = {"rewards": {name: "own"}, "behaviour": {"success": "success"}, "steps_asked": cell.steps}
    env = harness.RecordRewards(_Turns(), partial_ / "training", trained_with=name, **given)
    for _ in range(60):
        env.reset(seed=0)
        env.step(action)
    capsys.readouterr()
    env.close()
    said = {"recorder": capsys.readouterr().err}
    write_running(folder, {cell.id: Running(100.0, 6, 103.0)})
    with pytest.raises(SystemExit):
        main(["status", str(folder)])
    said["status"], said["report"] = capsys.readouterr().out, _reason(cell, partial_)
    console = Console(file=io.StringIO(), width=120)
    clock = count(0.0, 31.0)
    look = partial(so_far_of, store=store)
    with LiveProgress([cell], [], console, so_far=look, now=lambda: next(clock)) as progress:
        progress(Event("started", cell))
        progress(Event("progress", cell, steps=cell.steps, scalars={}))
    said["progress line"] = console.file.getvalue()
    live = Recording(partial_ / "training")
    live.look(cell.steps)
    return {**said, "live page": live.hint}


WORD = "In 9 of 9 pairs of neighbouring episodes the one that failed was paid more. It is a hint, not a verdict"
BROKEN = {
    "live page": "harness_plugins.watch.recorded.hint_of",
    "progress line": "harness.cli.progress.LiveProgress._tell_hint",
    "recorder": "harness.recorder.recorder.Recorder._tell_hint",
    "report": "harness.results.under_way.so_far",
    "status": "harness.cli.status.so_far_of",
}
"""Doors, and what makes each of them silent."""


def _silent(words):
    return {door for door, told in words.items() if WORD not in " ".join(told.split())}


@pytest.mark.parametrize("begun", [CARTPOLE], indirect=True, ids=[""])
def test_a_hint_stands_at_every_door(begun, capsys):
    """The same word of the same log; and none of an honest one."""
    assert _silent(words(*begun, capsys, 1)) == set()
    assert not any("It is a hint" in told for told in words(*begun, capsys, 0).values())


@pytest.mark.parametrize("door", BROKEN)
@pytest.mark.parametrize("begun", [CARTPOLE], indirect=True, ids=[""])
def test_a_door_that_says_nothing_is_found(begun, door, capsys, monkeypatch):
    """The mutants, a door each."""
    monkeypatch.setattr(BROKEN[door], lambda *given, **named: "" if door == "live page" else None)
    assert door in _silent(words(*begun, capsys, 1))
