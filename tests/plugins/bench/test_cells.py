"""The times of several cells, and how a terminal shows them."""

from dataclasses import replace

import pytest
from rich.console import Console

from harness.registry.choice import Choice
from harness_plugins.bench.cells import HEADINGS, Bench, bench_table, measure, time_grid
from harness_plugins.bench.stopwatch import PARTS, TRAINING
from harness_plugins.bench.timed_cell import Failed


@pytest.fixture
def two_cells(make_cell, make_plan):
    """A plan of two rewards, and one cell that cannot be."""
    cells = [make_cell(reward=Choice(name, (), name)) for name in ("baseline", "arp")]
    return make_plan(*cells, skipped=((make_cell(seed=1), "it cannot"),))


@pytest.fixture
def timed_order(monkeypatch, make_times, two_cells):
    """What was timed, in order, and with what in the cell's place; no process is started."""
    order = []

    def pretend(cell, folder, on_event, plugins):
        assert folder.parent.is_dir()
        order.append((cell.reward.label, folder.parent))
        if pretend.interrupted:
            raise KeyboardInterrupt
        return Failed("it broke") if cell.reward.label in pretend.broken else make_times(env=len(order))

    pretend.broken, pretend.interrupted = (), False
    monkeypatch.setattr("harness_plugins.bench.cells.time_cell", pretend)
    return order, pretend


def test_combinations_take_turns(timed_order, two_cells, toys):
    """A slow minute meets both."""
    order, _ = timed_order
    found = measure(two_cells, toys, 2, lambda event: None)
    assert [label for label, _ in order] == ["baseline", "arp", "baseline", "arp"]
    assert [len(timing.rounds) for timing in found.timings] == [2, 2]
    assert found.skipped == two_cells.skipped


def test_one_that_fails_is_not_tried_again(timed_order, two_cells, toys):
    """The others go on."""
    order, pretend = timed_order
    pretend.broken = ("baseline",)
    found = measure(two_cells, toys, 2, lambda event: None)
    assert [label for label, _ in order] == ["baseline", "arp", "arp"]
    assert found.failed == ((two_cells.cells[0], "it broke"),)
    assert [timing.cell for timing in found.timings] == [two_cells.cells[1]]


def test_nothing_is_kept(timed_order, two_cells, toys):
    """The folder is gone when it is over."""
    order, _ = timed_order
    measure(two_cells, toys, 1, lambda event: None)
    assert order
    assert not any(folder.exists() for _, folder in order)


def test_nothing_is_kept_when_it_is_interrupted(timed_order, two_cells, toys):
    """Ctrl-C passes, and leaves nothing."""
    order, pretend = timed_order
    pretend.interrupted = True
    with pytest.raises(KeyboardInterrupt):
        measure(two_cells, toys, 1, lambda event: None)
    assert not order[0][1].exists()


def test_parts_are_medians_over_the_rounds(make_timing):
    """Each for itself: one slow round does not show."""
    timing = make_timing({"env": 1.0}, {"env": 100.0}, {"env": 2.0})
    assert timing.seconds["env"] == 2.0
    assert timing.seconds["algorithm"] == 4.5


def test_medians_add_up_to_what_is_shown_as_the_whole(make_timing):
    """The training to its own parts."""
    timing = make_timing({"env": 1.0, "reward": 3.0}, {"reward": 5.0}, {"env": 2.0})
    assert timing.whole == pytest.approx(sum(timing.seconds[part] for part in PARTS))
    assert timing.training == pytest.approx(sum(timing.seconds[part] for part in TRAINING))


def test_steps_per_second_are_those_of_the_training(make_timing):
    """1,000 steps in 8 of 10 seconds."""
    timing = make_timing()
    assert timing.training == pytest.approx(8.0)
    assert timing.steps_per_second == pytest.approx(125.0)


def test_overhead_is_the_price_of_all_timed_calls(make_timing):
    """4,000 calls of half a microsecond."""
    assert make_timing(clock_seconds=5e-7).overhead == pytest.approx(2e-3)


def test_json_has_every_round(make_timing, make_cell):
    """With the parts of each, which add up to its own whole."""
    bench = Bench(2, (make_timing({}, {"env": 1.75}),), ((make_cell(), "it broke"),), (), "a cpu", {"numpy": "2"})
    data = bench.to_json()
    [combination] = data["combinations"]
    assert [entry["whole_s"] for entry in combination["rounds"]] == pytest.approx([10.0, 11.0])
    assert data["failed"] == [{"name": make_cell().title, "reason": "it broke"}]
    assert data["skipped"] == []


@pytest.fixture
def rows(make_timing):
    """Of a training of 8 of 10 seconds, 1,000 steps, by the name of the part."""
    return {name: cells for name, *cells in time_grid(make_timing()).rows}


def test_every_part_has_a_row_and_so_have_the_sums(rows):
    """In the order of the parts; as many columns as headings."""
    assert len(rows) == len(PARTS) + 2
    assert list(rows)[-2:] == ["training", "whole"]
    assert all(len(cells) == len(HEADINGS) - 1 for cells in rows.values())


def test_rows_have_seconds_share_and_microseconds_per_step(rows):
    """Of 10 s the algorithm took 4.5 in 1,000 steps."""
    assert rows["algorithm"] == ["4.500", "45.0%", "4,500.0"]


def test_what_does_not_grow_with_the_steps_has_no_time_per_step(rows):
    """A start takes as long for ten steps as for a million."""
    assert rows["start-up"] == ["1.000", "10.0%", ""]
    assert rows["whole"] == ["10.000", "100.0%", ""]


def test_shares_add_up(rows):
    """The parts' to the whole."""
    shares = [float(cells[1].rstrip("%")) for name, cells in rows.items() if name not in ("training", "whole")]
    assert sum(shares) == pytest.approx(100.0)


def test_notes_tell_speed_and_price(make_timing):
    """Steps per second of training, and what the timing added to each."""
    notes = " ".join(time_grid(make_timing(clock_seconds=5e-7)).notes)
    assert "125 environment steps per second" in notes
    assert "some 2.0 us of each step" in notes


def test_a_busy_machine_is_told(make_timing, make_times):
    """Where the process had to wait for a core, and only there."""
    timing = make_timing()
    waiting = replace(timing, rounds=(replace(make_times(), core_share=0.4),))
    assert "a core for 40% of the time" in " ".join(time_grid(waiting).notes)
    assert "a core for" not in " ".join(time_grid(timing).notes)


def test_table_names_the_combination_and_what_did_not_work(make_timing, make_cell):
    """The reason beside it, brackets and all."""
    bench = Bench(
        3, (make_timing({}, {}, {}),), ((make_cell(), "no [m] left"),), ((make_cell(), "it cannot"),), "a cpu", {}
    )
    console = Console(width=100)
    with console.capture() as capture:
        console.print(bench_table(bench))
    text = capture.get()
    assert "ideal · wander · baseline · fd100 · fd100-reach:horizon=5" in text
    assert "1,000 environment steps, medians of 3 rounds" in text
    assert "failed: ideal · wander · baseline · seed 0: no [m] left" in text
    assert "skipped: ideal · wander · baseline · seed 0: it cannot" in text
