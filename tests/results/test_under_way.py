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
from harness import load_results
from harness.cli import main
from harness.cli.progress import LiveProgress
from harness.cli.status import so_far_of
from harness.executor import Event
from harness.record import Store, TraceWriter, partial_folder
from harness.record.cell import Running, write_running
from harness.record.trace import COLUMN, SCALARS
from harness.results.under_way import so_far
from harness_plugins.watch.recorded import Recording, Trace

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

    def __init__(self, pays):
        self.pays = pays

    def reset(self, *, seed=None, options=None):
        return np.zeros(1, np.float32), {}

    def step(self, action):
        did, self.count = self.count // 3 % 2, self.count + 1
        return np.zeros(1, np.float32), float(self.pays(did)), True, False, {"success": did}


def _recorded(cell, folder, pays):
    """What a recorder writes of sixty episodes that are paid, by whether they succeed."""
    for path in folder.glob("training/*"):
        path.unlink()
    name = cell.reward.label
    given = {"rewards": {name: "own"}, "behaviour": {"success": "success"}, "steps_asked": cell.steps}
    env = harness.RecordRewards(_Turns(pays), folder / "training", trained_with=name, **given)
    for _ in range(60):
        env.reset(seed=0)
        env.step(0)
    env.close()
    return Recording(folder / "training")


def _traced(cell, folder, pays):
    """The trace of sixty such episodes of an arm, a part of whose pay is the task's."""
    rows = np.zeros((120, len(SCALARS) + 12))
    at = {name: rows[:, place] for name, place in COLUMN.items()}
    at["episode"][:], at["step"][1::2] = np.arange(120) // 2, 1.0
    did = at["reached"][1::2] = at["terminated"][1::2] = np.arange(60) // 3 % 2
    at["truncated"][1::2], at["reward_target"][1::2] = 1.0 - did, did
    at["reward"][1::2] = [pays(it) - it for it in did]
    with TraceWriter(folder / "trace.parquet", 6, 6) as writer:
        writer.append(rows)
    return Trace(folder / "trace.parquet")


def words(begun, capsys, pays):
    """What each door says of one training, whose pay depends on success alone."""
    (cell, partial_), write = begun
    folder, store = partial_.parents[1], Store(partial_.parents[1])
    capsys.readouterr()
    live = write(cell, partial_, pays)
    said = {"recorder": capsys.readouterr().err} if write is _recorded else {}
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


@pytest.fixture
def run(begun):
    """A training that goes on, and what writes its rows."""
    return begun, _recorded if begun[0].is_in_environment else _traced


@pytest.mark.parametrize("pays", [lambda did: -did, lambda did: 0.5 - did])
def test_a_hint_stands_at_every_door(run, capsys, pays):
    """The same word of the same log."""
    assert _silent(words(run, capsys, pays)) == set()


def test_an_honest_training_is_hinted_at_nowhere(run, capsys):
    """Of an arm, what the reward alone pays for failing, the task takes back: the learner is paid the sum."""
    assert not any("It is a hint" in told for told in words(run, capsys, lambda did: 0.5 * did).values())


ROWS = [(CARTPOLE, door) for door in BROKEN] + [(ARM, door) for door in BROKEN if door != "recorder"]
"""An arm's run is recorded by itself."""


@pytest.mark.parametrize(("begun", "door"), ROWS, indirect=["begun"])
def test_a_door_that_says_nothing_is_found(run, door, capsys, monkeypatch):
    """The mutants, a door each."""
    monkeypatch.setattr(BROKEN[door], lambda *given, **named: "" if door == "live page" else None)
    assert door in _silent(words(run, capsys, lambda did: -did))
