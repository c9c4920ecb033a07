import io
import itertools
import re
import time
from dataclasses import replace

import pytest
from rich.console import Console

from harness.cli.progress import LiveProgress
from harness.executor import Cell, Event
from harness.record.cell import BROUGHT
from harness.record.progress import RETURN, SPEED, SUCCESS
from harness.registry import Choice


def terminal(width, **given):
    """A terminal of so many columns that keeps what it shows."""
    return Console(file=io.StringIO(), force_terminal=True, width=width, **given)


@pytest.fixture
def pipe():
    """No terminal."""
    return Console(file=io.StringIO(), width=120)


def shown(console, cells, *words, done=(), reason=None, clock=time.monotonic, **given):
    """What is shown of cells of which the last one tells these words, of steps and numbers; and that it ends, or not.

    With a clock each word is a second later than the one before.
    """
    with LiveProgress(cells, done, console, now=clock, **given) as progress:
        progress(Event("started", cells[-1]))
        for steps, scalars in words:
            if isinstance(clock, Seconds):
                clock.now += 1.0
            progress(Event("progress", cells[-1], steps=steps, scalars=scalars))
        if reason is not None:
            progress(Event("ended", cells[-1], reason=reason))
    return console.file.getvalue()


STEPS = (6, {})


def test_a_running_cell_has_a_line_and_so_have_all_cells(make_cell):
    """On a terminal each running cell shows its steps, and one line stands for all."""
    told = shown(terminal(120), [make_cell()], STEPS)
    assert all(text in told for text in ("ideal wander baseline 0", "all cells", "6/12"))


def test_without_a_terminal_lines_are_printed(make_cell, pipe):
    """In a log a cell has a line when it starts and one when it ends, and nothing moves."""
    cell = make_cell()
    started, ended = shown(pipe, [cell], STEPS, reason="").splitlines()
    assert started == f"{cell.title}: started"
    assert ended.startswith(f"[1/1] {cell.title}: ")


def test_a_failed_cell_says_why(make_cell, pipe):
    """The reason stands in the line that ends the cell."""
    reason = "RuntimeError: the [arm] fell off"
    assert f"FAILED: {reason}" in shown(pipe, [make_cell()], STEPS, reason=reason)


def test_cells_that_were_done_are_counted(make_cell, pipe):
    """What is not run again is told, and the count goes on from there."""
    cells = [make_cell(seed=0), make_cell(seed=1)]
    told = shown(pipe, cells, STEPS, done=cells[:1], reason="")
    assert "1 of 2 cells were done before" in told
    assert "[2/2]" in told


def test_many_cells_begin_quickly(make_cell, pipe, monkeypatch):
    """Each cell is hashed a few times at most, however many there are: that is slow."""
    hashed = 0
    plain = Cell.__hash__

    def count(cell):
        nonlocal hashed
        hashed += 1
        return plain(cell)

    monkeypatch.setattr(Cell, "__hash__", count)
    cells = [make_cell(seed=seed) for seed in range(200)]
    LiveProgress(cells, cells[:100], pipe)
    assert hashed <= 2 * len(cells)


def lines_at(width, cells, scalars):
    """What stands on a terminal of so many columns while cells run, the line of all cells last."""
    console = terminal(width, color_system=None)
    with LiveProgress(cells, [], console) as progress:
        for cell in cells:
            progress(Event("started", cell))
            progress(Event("progress", cell, steps=12_000, scalars=scalars))
        console.file.truncate(0)
        progress._progress.refresh()
        shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", console.file.getvalue()).replace("\x00", "")
    lines = [line.split("\r")[-1] for line in shown.splitlines()]
    return [*(line for line in lines if "all cells" not in line and line.strip()), lines[0]]


@pytest.fixture
def long_cells(make_cell):
    """Two cells of 30,000 steps that differ by their rewards, whose names are long."""
    reward = Choice("arp", (), "arp:k1=2,k2=1.5,k3=0.25")
    return [make_cell(steps=30_000), make_cell(steps=30_000, reward=reward)]


LEARNED = {SUCCESS: 0.64, RETURN: 31.23}


@pytest.mark.parametrize("width", [60, 80, 120])
def test_a_cell_has_one_whole_line(long_cells, width):
    """How far it is, what it has learned and the time left, in one line that is not longer than the terminal."""
    first, second, _ = lines_at(width, long_cells, LEARNED)
    for line in (first, second):
        assert len(line.rstrip()) <= width
        assert "40 %" in line
        assert "success 64 %" in line
        assert line.rstrip().endswith("left")


def test_returns_of_several_rewards_do_not_stand_side_by_side(long_cells):
    """They have no common unit; of one reward they are shown."""
    assert not any("return" in line for line in lines_at(120, long_cells, LEARNED))
    assert "success 64 % return 31.2" in lines_at(80, long_cells[:1], LEARNED)[0]


def test_steps_stand_where_there_is_room(long_cells):
    """At 80 columns, not at 60."""
    assert "12,000/30,000" in lines_at(80, long_cells, LEARNED)[0]
    assert "30,000" not in lines_at(60, long_cells, LEARNED)[0]


def test_names_keep_what_tells_cells_apart(long_cells):
    """Where the whole name has no room, what is the same in all cells goes first."""
    assert lines_at(120, long_cells, LEARNED)[1].startswith("ideal wander arp:k1=2,k2=1.5,k3=0.25 0 ")
    assert lines_at(80, long_cells, LEARNED)[1].startswith("arp:k1=2,k2=1.5,k3=0.25 ")
    assert lines_at(50, long_cells, LEARNED)[0].startswith("baseline ")


def test_extreme_numbers_keep_the_line_whole(make_cell):
    """A return of ten digits, every episode a success, and no end in sight."""
    [line, _] = lines_at(60, [make_cell(steps=10**9)], {SUCCESS: 1.0, RETURN: -1.23456789e9})
    assert "success 100 % return -1.23e+09" in line
    assert len(line.rstrip()) <= 60


def test_before_an_episode_has_ended_nothing_is_claimed(make_cell):
    """Neither success nor return."""
    [line, _] = lines_at(80, [make_cell(steps=30_000)], {})
    assert "success" not in line
    assert "return" not in line


def test_the_line_of_an_ended_cell_tells_what_it_learned(make_cell, pipe):
    """In a log, where nothing moves, it is the only place."""
    assert "steps/s, success 64 %, return 31.2" in shown(pipe, [make_cell()], (12, LEARNED), reason="")


def test_the_lines_of_ended_cells_compare_no_pay(long_cells, pipe):
    """Where several rewards are trained, success alone is told."""
    told = shown(pipe, long_cells, (12, LEARNED), reason="")
    assert "success 64 %" in told
    assert "return" not in told


class Seconds:
    """A clock that is set."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def run_two_at_once(cells, progress, clock, *, startup=1.0, per_step=0.001, besides=2.0):
    """Cells that take so many seconds, two at a time; every second each tells how far it is."""
    waiting, running = list(cells), {}
    while waiting or running:
        while waiting and len(running) < 2:
            cell = waiting.pop(0)
            running[cell] = clock.now
            progress(Event("started", cell))
        clock.now += 1.0
        for cell, begun in list(running.items()):
            steps = round(max(clock.now - begun - startup, 0.0) / per_step)
            progress(Event("progress", cell, steps=min(steps, cell.steps)))
            if clock.now - begun >= startup + per_step * cell.steps + besides:
                del running[cell]
                progress(Event("ended", cell))


@pytest.fixture
def six(make_cell):
    """Six cells of 30,000 steps, 33 s each."""
    return [make_cell(steps=30_000, seed=seed) for seed in range(6)]


def test_the_time_left_is_told_within_ten_seconds(six, pipe):
    """Without a terminal: a line that is right but for what follows a training, then one at least every minute."""
    clock, told = Seconds(), []
    with LiveProgress(six, [], pipe, now=clock) as progress:

        def hear(event):
            before = len(pipe.file.getvalue())
            progress(event)
            told.extend((clock.now, line) for line in pipe.file.getvalue()[before:].splitlines())

        run_two_at_once(six, hear, clock)
    first, line = next((seconds, line) for seconds, line in told if "left" in line)
    assert first <= 10.0
    assert line == "about 85 s left: 6 trainings, 2 at once"  # 99 - 5 s; 9 of them are not known yet
    assert max(after - before for (before, _), (after, _) in itertools.pairwise(told)) <= 60.0


def test_an_ended_cell_says_how_long_the_others_take(six, pipe):
    """All that it took is known; the last says nothing."""
    clock = Seconds()
    with LiveProgress(six, [], pipe, now=clock) as progress:
        run_two_at_once(six, progress, clock)
    ended = [line for line in pipe.file.getvalue().splitlines() if line.startswith("[")]
    assert ended[1].endswith(", about 65 s left")
    assert ended[3].endswith(", about 35 s left")
    assert ended[5].endswith("steps/s")


@pytest.mark.parametrize(
    ("per_second", "seconds", "lines"),
    [
        (1000, 200, [f"about {minutes} min left: 1 training, 1 at once" for minutes in (17, 16, 15, 14)]),
        (0, 70, ["no step was measured yet: 1 training, 1 at once"]),
    ],
    ids=["a minute after the last line", "nothing is estimated before a step was measured"],
)
def test_a_long_silence_is_broken(make_cell, pipe, per_second, seconds, lines):
    """While a cell tells that it goes on."""
    words = [(per_second * second, {}) for second in range(1, seconds)]
    assert shown(pipe, [make_cell(steps=10**6)], *words, clock=Seconds()).splitlines()[1:] == lines


def test_a_run_that_may_end_sooner_says_at_most(six, pipe):
    """Where looks end it."""
    clock = Seconds()
    with LiveProgress(six, [], pipe, at_most=True, now=clock) as progress:
        run_two_at_once(six, progress, clock)
    assert "at most 85 s left: 6 trainings" in pipe.file.getvalue()
    assert "about" not in pipe.file.getvalue()


def test_all_cells_show_the_time_left_on_a_terminal(six):
    """In words where there is room, as a clock where there is not."""
    clock = Seconds()
    for width, told in ((80, "about 80 s left"), (60, "1:2")):
        clock.now = 0.0
        console = terminal(width, color_system=None)
        with LiveProgress(six, [], console, now=clock) as progress:
            for cell in six[:2]:
                progress(Event("started", cell))
            for second in range(1, 9):
                clock.now = float(second)
                for cell in six[:2]:
                    progress(Event("progress", cell, steps=1000 * second))
            progress._progress.refresh()
        assert told in console.file.getvalue()


@pytest.fixture
def of_others(make_cell):
    """A cell of an environment of others."""
    return make_cell(simulator=BROUGHT.simulator, robot=BROUGHT.robot, steps=10**6)


def test_a_training_in_which_no_episode_ends_is_told(of_others, pipe):
    """Once, after 10,000 steps."""
    told = shown(pipe, [of_others], *((steps, {SPEED: 1.0}) for steps in (9_999, 10_000, 20_000)))
    assert told.count("no episode has ended") == 1
    assert f"harness: {of_others.title}: no episode has ended in 10,000 steps of training\n" in told


def test_a_shorter_training_is_told_at_its_end(of_others, pipe):
    """If nothing has ended until then."""
    assert "no episode has ended in 50 steps" in shown(pipe, [replace(of_others, steps=50)], (50, {SPEED: 1.0}))


@pytest.mark.parametrize(
    "words",
    [[(10_000, {})], [(100, {SPEED: 1.0, RETURN: 0.0}), (10_000, {SPEED: 1.0})], [(9_999, {SPEED: 1.0})]],
    ids=["nothing was told", "one ended", "not odd yet"],
)
def test_nothing_is_told_before_it_is_known(of_others, pipe, words):
    """A return comes with the speed, and stays known."""
    assert "no episode" not in shown(pipe, [of_others], *words)


def test_a_task_of_an_arm_ends_its_episodes(make_cell, pipe):
    """Where a training goes on from a checkpoint, those before it are not known."""
    assert "no episode" not in shown(pipe, [make_cell(steps=10_000)], (10_000, {SPEED: 1.0}))
