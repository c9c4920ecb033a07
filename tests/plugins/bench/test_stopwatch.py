"""A cell that is measured while it is run, in this process."""

import time
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from harness.env import ReachVectorEnv
from harness.experiment.run_cell import run_cell
from harness.experiment.watch import UNWATCHED, Watch
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, POLICY, RANDOM, TRACE
from harness.registry.choice import Choice
from harness_plugins.bench.stopwatch import ENGINE, PARTS, CellTimes, Stopwatch

pytestmark = pytest.mark.usefixtures("toys")
MakeCell = Callable[..., Cell]


def _run(cell: Cell, folder: Path, watch: Watch = UNWATCHED) -> None:
    assert run_cell(cell, folder, lambda steps: None, watch=watch).reason == ""


def _time(cell: Cell, folder: Path) -> tuple[CellTimes, float]:
    """The times, and what passed outside."""
    begin = time.perf_counter()
    stopwatch = Stopwatch(begin)
    _run(cell, folder, stopwatch)
    times = stopwatch.stop()
    return times, time.perf_counter() - begin


@pytest.mark.parametrize("part", PARTS)
def test_every_part_takes_time(make_cell: MakeCell, tmp_path: Path, part: str):
    """None is nothing, and none is less."""
    assert _time(make_cell(), tmp_path / "cell")[0].seconds[part] > 0.0


def test_parts_add_up_to_the_whole(make_cell: MakeCell, tmp_path: Path):
    """To what passed between begin and stop, as somebody else measured it."""
    times, passed = _time(make_cell(steps=200), tmp_path / "cell")
    assert times.whole <= passed
    assert times.whole == pytest.approx(passed, abs=0.1)


def test_there_is_no_other_part(make_cell: MakeCell, tmp_path: Path):
    """Those that are declared, in their order."""
    assert tuple(_time(make_cell(), tmp_path / "cell")[0].seconds) == PARTS


def test_steps_are_those_of_the_training(make_cell: MakeCell, tmp_path: Path):
    """The evaluation's do not count."""
    assert _time(make_cell(steps=12), tmp_path / "cell")[0].steps == 12


@pytest.mark.parametrize("file", [TRACE, EVALUATION, RANDOM])
def test_a_timed_cell_leaves_the_same_rows(make_cell: MakeCell, tmp_path: Path, file: str):
    """Bit for bit, in training and in evaluation."""
    _run(make_cell(steps=60), tmp_path / "alone")
    _time(make_cell(steps=60), tmp_path / "timed")
    assert pq.read_table(tmp_path / "alone" / file).equals(pq.read_table(tmp_path / "timed" / file))


def test_the_same_where_arms_jump_and_where_decisions_last(make_cell: MakeCell, tmp_path: Path):
    """`place` for `drive`, and five steps a decision."""
    kinematic, task = Choice("kinematic", (), "kinematic"), Choice("arp-2021", (), "arp-2021")
    cell = make_cell(task=task, robot="unity-arm", simulator=kinematic)
    _run(cell, tmp_path / "alone")
    times, _ = _time(cell, tmp_path / "timed")
    assert pq.read_table(tmp_path / "alone" / TRACE).equals(pq.read_table(tmp_path / "timed" / TRACE))
    assert times.seconds["simulator"] > 0.0


def test_a_timed_cell_leaves_the_same_policy(make_cell: MakeCell, tmp_path: Path):
    """Every file of it, byte for byte."""
    _run(make_cell(), tmp_path / "alone")
    _time(make_cell(), tmp_path / "timed")
    alone, timed = (
        {path.name: path.read_bytes() for path in (tmp_path / name / POLICY).iterdir()} for name in ("alone", "timed")
    )
    assert alone == timed
    assert len(alone) >= 2


def test_engine_is_what_envs_call(make_cell: MakeCell, tmp_path: Path):
    """One whose arm is driven and one whose arm jumps, together; but for `close`, behind the training."""
    driven, jumping = Spy(), Spy()
    _run(make_cell(), tmp_path / "driven", driven)
    task, kinematic = Choice("arp-2021", (), "arp-2021"), Choice("kinematic")
    _run(make_cell(task=task, robot="unity-arm", simulator=kinematic), tmp_path / "jumping", jumping)
    assert driven.called | jumping.called == {*ENGINE, "close"}


class Spy(Watch):
    """Notes which methods of the engine are called."""

    def __init__(self) -> None:
        self.called: set[str] = set()
        self._inner: object = None

    def follow(self, env: ReachVectorEnv) -> None:
        """Stand between the env and its engine."""
        self._inner, env.simulation = env.simulation, self

    def __getattr__(self, name: str) -> object:
        found = getattr(self._inner, name)
        if callable(found):
            self.called.add(name)
        return found


class Slow:
    """A clock of which a second passes with every look."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """Later and later."""
        self.now += 1.0
        return self.now


class Env:
    """As much of an env as is timed, with an engine, a reward and a recorder that take 10, 20 and 40 seconds."""

    environment_steps = 3

    def __init__(self, clock: Slow) -> None:
        self._clock = clock
        self.simulation, self.reward, self.recorder = self, self._pay, self

    def drive(self) -> None:
        """The engine."""
        self._clock.now += 10.0

    def _pay(self, carry: object, sample: object) -> tuple[object, object]:
        self._clock.now += 20.0
        return carry, sample

    def append(self) -> None:
        """The recorder."""
        self._clock.now += 40.0

    def reset(self) -> None:
        """Quick."""

    def step(self) -> None:
        """All three, and 80 seconds of its own."""
        self.simulation.drive()
        self.reward(None, None)
        self.recorder.append()
        self._clock.now += 80.0


def _follow() -> tuple[Slow, Stopwatch, Env]:
    clock = Slow()
    stopwatch, env = Stopwatch(0.0, clock), Env(clock)
    stopwatch.follow(env)
    return clock, stopwatch, env


@pytest.mark.parametrize(
    ("part", "seconds"),
    [("simulator", 10.0), ("reward", 20.0), ("trace", 40.0), ("env", 80.0), ("algorithm", 160.0), ("start_up", 320.0)],
)
def test_each_second_counts_where_it_passes(part: str, seconds: float):
    """But for the looks at the clock, of which there are ten."""
    clock, stopwatch, env = _follow()
    clock.now += 320.0
    env.step()
    clock.now += 160.0
    stopwatch.enter("saving")
    times = stopwatch.stop()
    assert times.seconds[part] == pytest.approx(seconds, abs=8.0)
    assert times.whole == clock.now


def test_start_up_ends_with_the_first_call_of_the_env():
    """What an algorithm builds before it, and the library that it imports for it, are no training."""
    clock, stopwatch, env = _follow()
    clock.now += 100.0
    env.reset()
    clock.now += 1_000.0
    seconds = stopwatch.stop().seconds
    assert seconds["start_up"] == 101.0
    assert seconds["algorithm"] > 1_000.0


def test_the_end_of_the_trace_is_trace():
    """What is left of it is written behind the training."""
    clock, stopwatch, env = _follow()
    env.reset()
    stopwatch.enter("trace")
    clock.now += 100.0
    stopwatch.enter("saving")
    assert stopwatch.stop().seconds["trace"] == 101.0


def test_core_share_is_of_the_whole():
    """Of the time up to the end: here 30 of 120 seconds."""
    clock = Slow()
    stopwatch = Stopwatch(0.0, clock, core_clock=lambda: 30.0)
    clock.now = 119.0
    times = stopwatch.stop()
    assert (times.whole, times.core_share) == (120.0, 0.25)


def test_calls_are_counted():
    """A step is timed, and three calls within it."""
    _, stopwatch, env = _follow()
    env.step()
    assert stopwatch.stop().calls == 4


def test_a_training_that_makes_no_step_is_start_up():
    """The parts add up all the same."""
    clock, stopwatch, _ = _follow()
    times = stopwatch.stop()
    assert times.whole == clock.now == times.seconds["start_up"]
