"""Cells that other plugins made than those installed now."""

import importlib
import shutil
from pathlib import Path

import pytest

from harness import load_registry, load_robot
from harness.errors import UsageError
from harness.executor import Event
from harness.experiment import changed
from harness.experiment.changed import Change, changed_cells, refuse_changed
from harness.experiment.experiment import ExperimentRun
from harness.experiment.provenance import describe_environment
from harness.experiment.run_options import RunOptions
from harness.record import Store, partial_folder, read_manifest
from harness.registry import Choice
from tests.refusals import refused
from tests.registered import FD100

OLD, NEW = "9340a572" + "0" * 56, "f96dd784" + "0" * 56


HOOKS = """
import harness

@harness.hookimpl
def register_algorithms(register):
    register("cem", __name__ + "_learner:Cem", summary="a student's own")
"""
LEARNER = "import toy_arm\n\nclass Cem(toy_arm.Wander):\n    pass\n"
CEM = Choice("cem", (), "cem")


@pytest.fixture
def learner(toys, install):
    """The file of an algorithm of somebody's own, to be edited."""
    module = install("own-cem", HOOKS, learner=LEARNER)
    return Path(importlib.import_module(f"{module}_learner").__file__)


@pytest.fixture
def one_and_two(make_plan, make_cell):
    """The plan of one seed, and that of two."""
    cells = [make_cell(algorithm=CEM, seed=seed) for seed in range(2)]
    return make_plan(cells[0]), make_plan(*cells)


@pytest.fixture
def store(tmp_path, learner, one_and_two):
    """One seed was done; then the algorithm was edited."""
    folder = Store.claim(tmp_path / "out")
    _run(one_and_two[0], folder)
    learner.write_text(f"{LEARNER}\nITERATIONS = 2\n")
    return folder


def _run(plan, store, choice="refuse"):
    """The cells that were done."""
    events = []
    _asked(plan, store, choice).run(events.append)
    return [event.cell for event in events if event.kind == "ended"]


def _asked(plan, store, choice="refuse", executor=None):
    registry = load_registry()
    here = executor or registry.get("executors", "here").load()()
    return ExperimentRun(plan, store, registry, here, RunOptions(changed=choice))


def _source(store, cell):
    return read_manifest(store.cell_folder(cell)).environment["sources"]["algorithms"]


def _files(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != ".lock"}


def test_cells_of_the_installed_plugins_are_not_changed(make_cell, toys):
    """What a run records of its plugins is what the next run finds, robot included."""
    cell = make_cell()
    sources = describe_environment(cell, load_robot(cell.robot), toys)["sources"]
    assert set(sources) == set(cell.plugins)
    assert changed_cells({cell: sources}, toys) == {}


@pytest.mark.parametrize("kind", ["simulators", "tasks", "algorithms", "rewards", "robots"])
def test_every_kind_of_plugin_counts(make_cell, toys, kind):
    """Another simulator, task, algorithm, reward or robot is another result."""
    cell = make_cell()
    sources = describe_environment(cell, load_robot(cell.robot), toys)["sources"]
    [change] = changed_cells({cell: {**sources, kind: OLD}}, toys)[cell]
    assert change == Change(cell.plugins[kind], OLD, sources[kind])


def test_cells_without_recorded_sources_tell_nothing(make_cell, toys):
    """Nothing is known of them."""
    assert changed_cells({make_cell(): {}}, toys) == {}


def test_each_plugin_is_hashed_once(make_cell, toys, monkeypatch):
    """However many cells there are."""
    asked = []
    monkeypatch.setattr(changed, "source_hash", lambda target: asked.append(target) or NEW)
    cells = {make_cell(seed=seed): {"algorithms": OLD, "rewards": OLD} for seed in range(5)}
    assert len(changed_cells(cells, toys)) == 5
    assert len(asked) == 2


def test_message_names_cells_plugin_hashes_and_choices(make_cell):
    """In one line."""
    cells = {make_cell(seed=seed): [Change("cem", OLD, NEW)] for seed in range(2)}
    with pytest.raises(UsageError) as refused:
        refuse_changed(cells)
    assert str(refused.value) == (
        "2 done cells were made by another cem (9340a572, now f96dd784): --changed keep keeps these cells, and "
        "reports say so; --changed again trains them again; another --out leaves them alone"
    )


def test_message_about_many_plugins_stays_short(make_cell):
    """It names the first ones, and fits into a line that is not cut."""
    names = ("mujoco", "fd100-reach", "sac-fast", "arp", "fd100")
    with pytest.raises(UsageError) as refused:
        refuse_changed({make_cell(): [Change(name, OLD, NEW) for name in names]})
    assert "mujoco (9340a572, now f96dd784), fd100-reach (9340a572, now f96dd784) and 3 more: " in str(refused.value)
    assert len(str(refused.value)) <= 300


def test_run_beside_changed_cells_is_refused(store, one_and_two):
    """By default, and nothing is written."""
    before = _files(store.folder)
    with refused(r"1 done cell was made by another cem \([0-9a-f]{8}, now [0-9a-f]{8}\): "):
        _run(one_and_two[1], store)
    assert _files(store.folder) == before


def test_run_of_changed_cells_alone_is_refused(store, one_and_two):
    """Who edits a plugin and asks for the same again does not get the old results without a word."""
    with refused("1 done cell was made by another cem"):
        _run(one_and_two[0], store)


def test_unchanged_cells_go_on(toys, learner, one_and_two, tmp_path):
    """As ever."""
    store = Store.claim(tmp_path / "out")
    assert _run(one_and_two[0], store) == list(one_and_two[0].cells)
    assert _run(one_and_two[1], store) == [one_and_two[1].cells[1]]


def test_kept_cells_are_not_run_again(store, one_and_two):
    """The others are done beside them."""
    first, second = one_and_two[1].cells
    before = _files(store.cell_folder(first))
    assert _run(one_and_two[1], store, "keep") == [second]
    assert _files(store.cell_folder(first)) == before
    assert _source(store, first) != _source(store, second)


def test_changed_cells_are_done_again(store, one_and_two):
    """By what is installed now; after that there is nothing to refuse."""
    first, second = one_and_two[1].cells
    assert _run(one_and_two[1], store, "again") == [first, second]
    assert _source(store, first) == _source(store, second)
    assert _run(one_and_two[1], store) == []


def test_interrupted_cell_stays_until_it_is_replaced(store, one_and_two):
    """A done cell that is being done again is there until the new one is whole."""
    before = _files(store.folder / "cells")

    class Interrupted:
        def run(self, jobs, at_once, on_event):
            partial_folder(jobs[0].folder).mkdir()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        _asked(one_and_two[0], store, "again", Interrupted()).run()
    assert _files(store.folder / "cells") == before


def test_cell_that_was_lost_while_it_was_done_again_has_failed(store, one_and_two):
    """The old result is no result of what was asked for."""
    [cell] = one_and_two[0].cells

    class Losing:
        def run(self, jobs, at_once, on_event):
            for job in jobs:
                on_event(Event("ended", job.cell, reason="lost on the way"))

    results = _asked(one_and_two[0], store, "again", Losing()).run()
    assert [(item.cell, item.reason) for item in results.failed] == [(cell, "lost on the way")]


def test_other_choices_are_refused():
    """However they were given."""
    with refused("changed='ask': allowed are refuse, keep, again"):
        RunOptions(changed="ask")  # type: ignore[arg-type]


DRIVEN = Choice("ideal", (("drive", "servo"),), "ideal:drive=servo")
"""A simulator that is set to move the arm by the drives of its robot.toml."""


@pytest.mark.parametrize(("simulator", "count"), [(Choice("ideal", (), "ideal"), 0), (DRIVEN, 1)])
def test_drives_count_where_they_move_the_arm(make_cell, toys, tmp_path, simulator, count):
    """Another `[servo]` in robot.toml changes the cells whose simulator drives with it, and no others."""
    folder = shutil.copytree(FD100.folder, tmp_path / "arm")
    cell = make_cell(simulator=simulator, robot=str(folder))
    recorded = describe_environment(cell, load_robot(folder), toys)["sources"]
    toml = folder / "robot.toml"
    toml.write_text(toml.read_text().replace("latency_s = 0.01", "latency_s = 0.02"))
    assert len(changed_cells({cell: recorded}, toys)) == count
