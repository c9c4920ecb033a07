"""What a live page is told of trainings."""

import shutil

import pytest

from harness.record import TrainingFacts
from harness_plugins.watch.trainings import newest, source_of
from tests.refusals import refused


def test_a_training_is_seen_while_it_is_recorded(record, step, tmp_path):
    """Its reward, its seed, how far it is, and what its episodes came to."""
    step(record("runs/one", steps_asked=100), 7)
    shown = source_of(tmp_path / "runs").look()
    (training,) = shown.trainings
    assert (training.reward, training.name, training.state) == ("counted", "one, seed 0", "running")
    assert (training.steps, training.asked, training.measure, training.is_share) == (7, 100, "success", True)
    assert training.blocks.means.tolist() == [[6.0, 1.0, 3.0, 3.0]] * 2
    assert training.blocks.terms == ("left", "again")
    assert shown.news == "1 training recorded, 1 running."


def test_the_folder_of_one_recording_is_watched_too(record, step, tmp_path):
    """Without a folder around it."""
    step(record("alone"), 3)
    assert source_of(tmp_path / "alone").look().trainings[0].name == "alone, seed 0"


def test_trainings_come_as_they_begin(record, step, tmp_path):
    """One that ends says so, and one that was killed; evaluations are counted alone."""
    one = record("runs/one")
    step(one, 3)
    source = source_of(tmp_path / "runs")
    assert len(source.look().trainings) == 1
    one.close()
    step(record("runs/two", reward="other"), 3)
    record("runs/evaluation", evaluation=True).close()
    record("runs/killed")._recorder._writer._lock.release()
    shown = source.look()
    assert [(it.name.partition(",")[0], it.state) for it in shown.trainings] == [
        ("killed", "stopped"),
        ("one", "done"),
        ("two", "running"),
    ]
    assert shown.news == "3 trainings recorded, 1 running, 1 ended, 1 stopped before the end, 1 evaluation."


def test_time_left_is_that_of_the_slowest(record, step, tmp_path):
    """By the speed since it was first seen; nothing before that is known, or where nobody said how long it will be."""
    now = [0.0]
    env = record("runs/one", steps_asked=300)
    step(env, 30)
    source = source_of(tmp_path / "runs")
    source._now = lambda: now[0]
    assert source.look().left == ""
    step(env, 30)
    now[0] = 2.0
    assert source.look().left == ""
    now[0] = 10.0
    assert source.look().left == "About 80 s left."
    step(record("runs/two"), 30)
    now[0] = 20.0
    assert "left" in source.look().left


def test_a_damaged_recording_is_named(record, step, tmp_path):
    """And the others are shown."""
    step(record("runs/one"), 3)
    step(record("runs/two"), 3)
    next((tmp_path / "runs/two").glob("steps-*")).write_bytes(b"PAR1")
    shown = source_of(tmp_path / "runs").look()
    assert [it.name for it in shown.trainings] == ["one, seed 0"]
    assert "two" in shown.news


def test_a_recording_may_go_while_it_is_watched(record, step, tmp_path):
    """It is left out; a folder that is gone is called so."""
    env = record("runs/one")
    step(env, 3)
    source = source_of(tmp_path / "runs")
    source.look()
    env.close()
    shutil.rmtree(tmp_path / "runs/one")
    assert source.look().trainings == ()
    shutil.rmtree(tmp_path / "runs")
    with refused("any more"):
        source.look()


@pytest.mark.parametrize("name", ["nowhere", "empty"])
def test_what_is_nothing_is_refused(tmp_path, name):
    """In a line that says what to name."""
    (tmp_path / "empty").mkdir()
    with refused(name):
        source_of(tmp_path / name)


def test_running_ones_are_drawn_first():
    """Then the newest others, in the order in which they stand."""
    is_running = [number in {0, 5} for number in range(100)]
    assert newest(is_running) == [0, 5, *range(100 - 24 + 2, 100)]
    assert newest([False] * 3) == [0, 1, 2]


def test_facts_are_read_again(record, step, tmp_path):
    """What a recorder learns later, as its terms, is known then."""
    env = record("runs/one")
    source = source_of(tmp_path / "runs")
    assert source.look().trainings[0].blocks.terms == ()
    step(env, 6)
    assert source.look().trainings[0].blocks.terms == ("left", "again")
    assert TrainingFacts.read(tmp_path / "runs/one/recording-0.json").terms
