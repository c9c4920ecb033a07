"""Cells on the nodes of a Ray cluster."""

import hashlib
import os
import random
import shutil
import threading
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

import harness
from harness.executor import CellOptions, Job, run_jobs
from harness.experiment.plan import Experiment, expand
from harness.record import LOG, MANIFEST, Store
from harness_plugins.executors.ray import Ray
from tests.refusals import refused
from tests.registered import REGISTRY

pytestmark = pytest.mark.slow

KILLED_PROCESSES, KILLED_NODES = 30, 5


def _run(executor, cells, folder, at_once=4, on_event=None):
    told = []

    def hear(event):
        told.append(event)
        if on_event:
            on_event(event)

    executor.run(_jobs(cells, folder), at_once, hear)
    return told


def _jobs(cells, folder):
    return [Job(cell, folder / cell.id, CellOptions(checkpoint_every=500)) for cell in cells]


def _left(folder):
    paths = [path for path in folder.rglob("*") if path.is_file() and path.name not in (MANIFEST, LOG)]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def test_it_is_said_once_that_no_node_is_left(tmp_path, monkeypatch, capsys):
    """After some seconds, and that the run waits; not while a node can be used, nor while one is asked what it has."""
    from harness_plugins.ray_cluster import fleet as module

    nodes, now = module.Nodes([], tmp_path, 1.0, 0.0), [time.monotonic()]
    nodes.known["a"] = module.Node("a", "a", 1, None)
    alive = True
    monkeypatch.setattr(module.ray, "nodes", lambda: [{"NodeID": "a", "Alive": alive}])
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])

    def said_after(seconds):
        now[0] += seconds
        nodes.look(at_once=True)
        return str(capsys.readouterr().err)

    assert said_after(60.0) == ""
    alive = False
    assert said_after(1.0) == ""
    assert "The run waits, and goes on when a node joins. Ctrl-C ends it" in said_after(module.ALONE_AFTER)
    assert said_after(60.0) == ""
    alive = True
    assert said_after(1.0) == ""
    alive = False
    assert "every node of the Ray cluster" in said_after(module.ALONE_AFTER)
    nodes.close()


def test_a_cell_whose_process_is_lost_is_begun_again(toys, that, two_nodes, tmp_path):
    """It is told to have begun once, and is done; the processes that it had started end with it."""
    note = tmp_path / "note"
    killed = []

    def kill(event):
        if event.kind == "started":
            while not note.exists():
                time.sleep(0.05)
            (slot,) = [slot for slot in two_nodes.slots() if slot.children()]
            killed.extend(slot.children())
            slot.kill()

    cell = that("last", note)
    told = _run(Ray(address=two_nodes.address), [cell], tmp_path / "cells", on_event=kill)
    assert [event.kind for event in told if event.kind != "progress"] == ["started", "ended"]
    assert Store(tmp_path).examine(cell).status == "done"
    assert not any(process.is_running() for process in killed)


def test_a_cell_whose_process_is_killed_is_begun_again(toys, that, tmp_path):
    """As one whose node is lost, and told to have begun once; one that crashes fails, as it would anywhere."""
    pytest.importorskip("ray")
    told = _run(Ray(retries=2), [that("be killed"), that("_exit")], tmp_path / "cells", 1)
    assert [event.kind for event in told if event.kind != "progress"] == ["started", "ended"] * 2
    killed, crashed = (event.reason for event in told if event.kind == "ended")
    assert killed.startswith("lost 3 times, the last time on node ")
    assert killed.endswith(": its process was ended by SIGKILL")
    assert crashed == "its process ended with exit status 3 before the cell did"


def test_a_cell_that_is_lost_too_often_fails(toys, that, two_nodes, tmp_path):
    """With the number of times, and where; the other cell is done."""
    note = tmp_path / "note"
    lost = that("wait", note)

    def kill(event):
        if event.cell == lost and event.kind == "started":
            while not note.exists():
                time.sleep(0.05)
            for slot in two_nodes.slots():
                slot.kill()

    told = _run(Ray(address=two_nodes.address, retries=0), [lost], tmp_path / "cells", 1, on_event=kill)
    assert told[-1].kind == "ended"
    assert told[-1].reason.startswith("lost 1 times, the last time on node ")


def test_a_node_whose_sources_differ_gets_no_cells(toys, make_cell, two_nodes, tmp_path, capsys):
    """It is named, with what differs; where no other node is left, that is an error."""
    other = tmp_path / "other"
    shutil.copytree(Path(harness.__file__).parent, other / "harness")  # compiled files too: the node answers in time
    with (other / "harness" / "reach.py").open("a") as file:
        file.write("# changed\n")
    two_nodes.kill_node()
    two_nodes.add(PYTHONPATH=os.pathsep.join([str(other), os.environ["PYTHONPATH"]]))
    two_nodes.wait(3)
    executor, cells = Ray(address=two_nodes.address), [make_cell(seed=seed) for seed in range(3)]
    assert [event.reason for event in _run(executor, cells, tmp_path / "cells") if event.kind == "ended"] == [""] * 3
    complaint = capsys.readouterr().err
    assert "gets no cells: source of harness " in complaint
    assert " here, " in complaint
    two_nodes.kill_node()
    with refused(r"No node of the Ray cluster can run these cells: .*source of harness"):
        _run(executor, cells, tmp_path / "again")


def test_a_plugin_that_a_node_lacks_is_named(two_nodes, tmp_path, toys, make_cell):
    """The nodes were started without the toys."""
    with refused("No simulator 'ideal'"):
        _run(Ray(address=two_nodes.address), [make_cell()], tmp_path / "cells")


def test_plugins_come_by_a_runtime_environment(two_nodes, tmp_path, toys, make_cell, toy_folder):
    """Here by a path that the nodes see."""
    file = tmp_path / "env.toml"
    file.write_text(f'[env_vars]\nPYTHONPATH = "{toy_folder}{os.pathsep}{os.environ["PYTHONPATH"]}"\n')
    told = _run(Ray(address=two_nodes.address, runtime_env=str(file)), [make_cell()], tmp_path / "cells")
    assert (told[-1].kind, told[-1].reason) == ("ended", "")


def test_cells_that_no_node_has_room_for_are_refused(toys, make_cell, two_nodes, tmp_path):
    """Ray itself would wait for such a node for ever."""
    with refused("it has no room for 64 CPUs"):
        _run(Ray(address=two_nodes.address, cpus=64), [make_cell()], tmp_path / "cells")


def test_a_cluster_that_is_not_there_is_refused(toys, make_cell, tmp_path):
    """The message says how to start one."""
    pytest.importorskip("ray")
    with refused("No Ray cluster at address=auto can be joined: start one"):
        _run(Ray(address="auto"), [make_cell()], tmp_path / "cells")


@pytest.mark.parametrize("place", ["shared", "hidden"])
def test_killed_processes_and_nodes_lose_nothing(two_nodes, tmp_path, place):
    """Afterwards every cell is done, and every byte is that of a run in processes of this machine."""
    matrix = Experiment(
        sim=["kinematic"], algo=["random"], reward=["arp"], seeds=20, steps=4_000, evaluation_episodes=2,
        task="fd100-reach:horizon=50",
    )  # fmt: skip
    cells = expand(matrix, REGISTRY).cells
    assert len(cells) == 40
    run_jobs(_jobs(cells, tmp_path / "processes"), 2, lambda event: None)
    ended, rng = threading.Event(), random.Random(7)
    killed = {"processes": 0, "nodes": 0}

    def disturb():
        while not ended.wait(rng.uniform(0.3, 0.9)):
            if killed["nodes"] < KILLED_NODES and killed["processes"] >= 5 * killed["nodes"] + 5:
                two_nodes.kill_node()
                killed["nodes"] += 1
                two_nodes.add()
            elif killed["processes"] < KILLED_PROCESSES:
                with suppress(psutil.NoSuchProcess, IndexError):
                    rng.choice([slot for slot in two_nodes.slots() if slot.children()]).kill()
                    killed["processes"] += 1

    thread = threading.Thread(target=disturb)
    thread.start()
    try:
        told = _run(
            Ray(address=two_nodes.address, retries=KILLED_PROCESSES + KILLED_NODES), cells, tmp_path / place / "cells"
        )
    finally:
        ended.set()
        thread.join()
    assert killed == {"processes": KILLED_PROCESSES, "nodes": KILLED_NODES}
    assert [event.reason for event in told if event.kind == "ended"] == [""] * len(cells)
    assert _left(tmp_path / place / "cells") == _left(tmp_path / "processes")
