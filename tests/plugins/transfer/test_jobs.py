"""Policies trained in one simulator, evaluated in others."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness import load_registry, load_results
from harness.errors import NewerFormat
from harness.executor import Cell
from harness.experiment.plan import check_experiment, expand
from harness.record import EVALUATION, MANIFEST, POLICY, partial_folder, read_manifest, read_trace
from harness.record.cell import BROUGHT
from harness.record.folder import WEIGHTS
from harness.registry import Choice, choose
from harness_plugins.transfer import (
    TRANSFER,
    load_transfers,
    plan_transfers,
    read_transfer,
    run_transfers,
    simulator_id,
    transfer,
)
from harness_plugins.transfer.jobs import evaluate_elsewhere
from tests.refusals import refused
from tests.registered import FD100
from tests.stores import create_store

EASY = "fd100-reach:epsilon=0.25,horizon=40"
"""Acting at random reaches some targets; an arm that does not move reaches none."""


@pytest.fixture
def train(toys, run_once, tmp_path):
    """Yields an experiment of the toys that has run."""

    def train_toys(**keys):
        given = {"sim": ["ideal"], "algo": ["wander"], "reward": ["arp"], "task": EASY, "seeds": 2, "steps": 6}
        return run_once(expand(check_experiment({**given, "evaluation_episodes": 12, **keys}), toys), tmp_path / "mine")

    return train_toys


def folder_of(results, cell, simulator):
    """Where the transfer of a cell's policy is."""
    return results.folder / TRANSFER / cell.id / simulator_id(choose(load_registry(), "simulators", simulator))


def success(transfers, home, place):
    """Of the first matrix."""
    data = transfers.matrices[0].to_json()
    return data["success"][data["trained_in"].index(home)][data["evaluated_in"].index(place)]["value"]


def test_evaluation_is_the_cell_s_own(train, transferred_here):
    """In a simulator that moves alike, the same policy leaves the same trace as at home, bit for bit."""
    results = train(sim=["ideal", "kinematic"], task="fd100-reach:horizon=8", seeds=1)
    transfer(results.folder, "ideal,kinematic")
    for cell in results.done_cells:
        other = "kinematic" if cell.simulator.name == "ideal" else "ideal"
        home = read_trace(results.store.cell_folder(cell) / EVALUATION)
        away = read_trace(folder_of(results, cell, other) / EVALUATION)
        assert len(home) == len(away) > 0
        for name, column in home.rows().columns.items():
            assert_allclose(away[name], column, atol=1e-12)


def test_matrix_tells_the_simulators_apart(train, transferred_here):
    """Success is that of the simulator evaluated in: some where arms move, none where they are stuck."""
    transfers = transfer(train(sim=["ideal", "stuck"], seeds=1).folder, "ideal,stuck")
    for home in ("ideal", "stuck"):
        assert success(transfers, home, "ideal") > 0.0
        assert success(transfers, home, "stuck") == 0.0


def test_mutant_that_stays_at_home_is_caught(transferred_here, train, monkeypatch):
    """An evaluation that forgot to change the simulator would give the success of the wrong one."""
    monkeypatch.setattr(
        "harness_plugins.transfer.jobs.replace",
        lambda thing, **changes: thing if isinstance(thing, Cell) else replace(thing, **changes),
    )
    transfers = transfer(train(sim=["ideal", "stuck"], seeds=1).folder, "ideal,stuck")
    assert success(transfers, "ideal", "stuck") > 0.0
    assert success(transfers, "stuck", "ideal") == 0.0


def test_home_is_what_was_recorded(train, transferred_here):
    """Where a policy was trained it is not evaluated again: the recorded evaluation counts, as the report reads it."""
    results = train()
    transfers = transfer(results.folder, "ideal,stuck")
    assert [order.work.simulator.name for order in transferred_here] == ["stuck"] * 4
    rates = [
        results.measured(cell).own["success_rate"]
        for cell in results.done_cells
        if cell.reward.label == transfers.matrices[0].group.reward.label
    ]
    assert success(transfers, "ideal", "ideal") == pytest.approx(np.mean(rates))


def test_second_call_does_only_what_is_missing(train, transferred_here):
    """Nothing, if nothing is; what is named anew; a policy that is another one now."""
    results = train(seeds=1)
    transfer(results.folder, "stuck")
    first = len(transferred_here)
    transfer(results.folder, "stuck")
    assert len(transferred_here) == first == 2
    transfer(results.folder, ["stuck", "stuck:note=x"])
    assert [order.work.simulator.label for order in transferred_here[first:]] == ["stuck:note=x"] * 2
    folder = results.store.cell_folder(results.done_cells[0])
    weights = folder / POLICY / WEIGHTS
    assert len(load_transfers(results).matrices) == 2
    weights.write_bytes(weights.read_bytes()[:-4] + b"abcd")
    read_manifest(folder).write(folder)  # as a cell leaves it that was trained again
    assert len(load_transfers(results).matrices) == 1
    transfer(results.folder, "stuck")
    assert len(transferred_here) == 5


@pytest.mark.parametrize(
    ("then", "reason"),
    [("raise", "RuntimeError: the arm fell off"), ("diverge", "SimulationDiverged"), ("sys.exit", "SystemExit: 0")],
)
def test_failed_evaluation_costs_itself_alone(train, transferred_here, then, reason):
    """It is recorded with its reason and is tried again; the others are done."""
    results = train(seeds=1)
    transfers = transfer(results.folder, f"stuck:then={then},stuck")
    assert len(transfers.failed) == 2
    assert all(failure.record.reason.startswith(reason) for failure in transfers.failed)
    assert success(transfers, "ideal", "stuck") == 0.0
    assert success(transfers, "ideal", f"stuck:then={then}") is None
    assert "1 of 1 failed" in [mean["note"] for mean in transfers.matrices[0].to_json()["success"][0]]
    done = len(transferred_here)
    transfer(results.folder, f"stuck:then={then},stuck")
    assert len(transferred_here) == done + 2


def test_process_that_dies_costs_itself_alone(train):
    """In processes of their own: one that exits is a failed evaluation, the others are done."""
    results = train(seeds=1)
    transfers = transfer(results.folder, "stuck:then=_exit,stuck", jobs=2)
    reasons = {failure.record.reason for failure in transfers.failed}
    assert reasons == {"its process ended with exit status 3 before the evaluation did"}
    assert success(transfers, "ideal", "stuck") == 0.0
    assert not list((results.folder / TRANSFER).glob("*/.*"))


def test_killed_call_loses_what_it_was_at(train, tmp_path):
    """What was done before a SIGKILL is kept; the next call does the rest, and the folder holds nothing else."""
    results = train()
    note = tmp_path / "pid"
    os.mkfifo(note)
    script = (
        "import sys; from harness_plugins.transfer.jobs import transfer; transfer(sys.argv[1], sys.argv[2], jobs=1)"
    )
    call = subprocess.Popen([sys.executable, "-c", script, results.folder, f"stuck,stuck:then=wait,note={note}"])
    note.read_text()  # comes when the first policy was in "stuck" and waits in the other
    call.send_signal(signal.SIGKILL)
    call.wait()
    done = [folder for folder in (results.folder / TRANSFER).glob("*/*") if read_transfer(folder)]
    assert len(done) == 1
    kept = (done[0] / EVALUATION).stat()
    assert success(transfer(results.folder, "stuck"), "ideal", "stuck") == 0.0
    assert (done[0] / EVALUATION).stat().st_mtime_ns == kept.st_mtime_ns
    assert len(list((results.folder / TRANSFER).glob("*/*"))) == 4


def test_policy_that_is_gone_fails_alone_and_what_was_known_stays(train, transferred_here):
    """Weights that were deleted cannot be evaluated again; what they did before is still told."""
    results = train(seeds=1)
    transfer(results.folder, "stuck")
    cell = results.done_cells[0]
    (results.store.cell_folder(cell) / POLICY / WEIGHTS).unlink()
    transfers = transfer(results.folder, "stuck,stuck:note=x")
    assert success(transfers, "ideal", "stuck") == 0.0
    (failure,) = transfers.failed
    assert (failure.cell, failure.record.simulator.label) == (cell, "stuck:note=x")
    assert "holds no readable policy" in failure.record.reason


def test_record_says_what_was_done(train, transferred_here):
    """Cell, simulator, versions, sources of what made it - not of the algorithm, which may be gone."""
    results = train(seeds=1)
    transfer(results.folder, "stuck")
    cell = results.done_cells[0]
    record = read_transfer(folder_of(results, cell, "stuck"))
    assert (record.cell, record.simulator.label, record.status) == (cell.id, "stuck", "done")
    assert set(record.environment["sources"]) == {"simulators", "tasks", "rewards", "robots"}
    assert "numpy" in record.environment["versions"]


def test_default_is_every_simulator_that_can_be_used(train, distant):
    """The experiment's, parameters and all, and the registered ones; one whose library is missing is said."""
    plan = plan_transfers(train(sim=["stuck:note=x"], seeds=1), None, load_registry())
    labels = {job.simulator.label for job in plan.jobs}
    assert {"stuck", "ideal", "mujoco", "kinematic"} <= labels
    assert not {"stuck:note=x", "distant"} & labels
    (line,) = (line for line in plan.left_out if line.startswith("distant"))
    assert "pip install 'far-away[engine]'" in line


@pytest.mark.parametrize(
    ("to", "jobs", "told"),
    [
        ("stock", None, "Did you mean 'stuck'?"),
        ("stuck:dt=1", None, "has no parameter 'dt'"),
        ("", None, "is malformed"),
        ("stuck", 0, "jobs=0: must be at least 1"),
    ],
)
def test_bad_arguments_are_refused(train, to, jobs, told):
    """Before anything is written."""
    results = train(seeds=1)
    with refused(told.replace("?", r"\?")):
        transfer(results.folder, to, jobs)
    assert not (results.folder / TRANSFER).exists()


def test_missing_plugins_are_refused(train, monkeypatch):
    """A task that is not registered any more is told, with what there is."""
    results, registry = train(seeds=1), load_registry()
    del registry.specs["tasks", "fd100-reach"]
    with refused("cannot be evaluated: No task 'fd100-reach'"):
        plan_transfers(results, "stuck", registry)


def test_nothing_trained_is_refused(toys, make_plan, make_cell, tmp_path):
    """An experiment without a done cell has no policy."""
    create_store(tmp_path / "empty", make_plan(make_cell()))
    with refused("has no finished cell"):
        transfer(tmp_path / "empty")


def test_cells_in_an_environment_are_refused(toys, make_plan, make_cell, tmp_path):
    """Done or not: there is no arm that could move elsewhere. It says what to do instead."""
    cell = make_cell(simulator=BROUGHT.simulator, robot=BROUGHT.robot, task=Choice("pendulum", (), "pendulum"))
    create_store(tmp_path, make_plan(cell)).record(cell, "failed", "it fell")
    with refused(r"harness transfer needs traces of an arm.*: harness report .* compares them"):
        plan_transfers(load_results(tmp_path), None, toys)


def test_folder_in_use_is_refused(train):
    """While a run or another transfer is at it."""
    results = train(seeds=1)
    plan = plan_transfers(results, "stuck", load_registry())
    with results.store.locked(), refused("Another run is using"):
        run_transfers(plan, 1)


def test_newer_record_is_told(train, transferred_here):
    """With the file's name; it is not done again."""
    results = train(seeds=1)
    transfer(results.folder, "stuck")
    path = folder_of(results, results.done_cells[0], "stuck") / MANIFEST
    path.write_text(json.dumps({**json.loads(path.read_text()), "format": 99}))
    with pytest.raises(NewerFormat, match=r"manifest\.json has format 99"):
        load_transfers(results)


@pytest.mark.parametrize("name", [MANIFEST, EVALUATION])
def test_damaged_transfer_costs_itself_alone_and_is_done_again(train, transferred_here, name):
    """It is a line beside the others."""
    results = train(seeds=2)
    transfer(results.folder, "stuck")
    path = folder_of(results, results.done_cells[0], "stuck") / name
    path.write_bytes(path.read_bytes()[:50])
    found = load_transfers(results)
    [failure] = found.failed
    assert (failure.cell, failure.record.status) == (results.done_cells[0], "damaged")
    assert str(path) in failure.record.reason
    assert len(found.matrices) == 2
    count = len(transferred_here)
    assert transfer(results.folder, "stuck").failed == ()
    assert len(transferred_here) == count + 1


def test_reading_needs_no_plugin_s_engine(train, transferred_here):
    """The matrix of an experiment is read without Gymnasium and without an engine."""
    results = train(seeds=1)
    transfer(results.folder, "stuck")
    script = (
        "import sys\nfrom harness import load_results\n"
        "from harness_plugins.transfer.matrix import load_transfers\n"
        "assert load_transfers(load_results(sys.argv[1])).matrices\n"
        "assert not {'gymnasium', 'mujoco', 'torch', 'toy_arm'} & set(sys.modules)"
    )
    environment = {**os.environ, "HARNESS_PLUGINS": "-simulators,-toys"}
    subprocess.run([sys.executable, "-c", script, results.folder], check=True, env=environment)


@pytest.mark.slow
def test_trained_policy_goes_between_engines(tmp_path):
    """SAC's policies of mujoco and kinematic: the evaluations differ, and each is the same when done again."""
    import harness

    harness.run(sim="mujoco,kinematic", algo="sac", seeds=1, steps=1000, evaluation_episodes=10, out=tmp_path / "real")
    assert not transfer(tmp_path / "real", "mujoco,kinematic", jobs=2).failed
    results = load_results(tmp_path / "real")
    for cell in results.done_cells:
        other = "kinematic" if cell.simulator.name == "mujoco" else "mujoco"
        folder = folder_of(results, cell, other)
        home, away = read_trace(results.store.cell_folder(cell) / EVALUATION), read_trace(folder / EVALUATION)
        assert_array_equal(home["target_x"][home["step"] == 0], away["target_x"][away["step"] == 0])
        assert len(home) != len(away) or (home["distance"] != away["distance"]).any()
        before = (folder / EVALUATION).read_bytes()
        evaluate_elsewhere(results.store.cell_folder(cell), choose(load_registry(), "simulators", other), folder)
        assert (folder / EVALUATION).read_bytes() == before
        assert not partial_folder(folder).exists()


def test_policies_go_to_drives_that_their_robot_describes(train):
    """`--to mujoco:drive=servo` is a simulator of its own."""
    (job, *_) = plan_transfers(train(seeds=1), "mujoco:drive=servo", load_registry()).jobs
    assert job.simulator.label == "mujoco:drive=servo"


def test_policies_of_a_robot_without_drives_do_not(train, tmp_path):
    """One line says what is missing, before anything is evaluated."""
    (tmp_path / "arm.urdf").write_text(FD100.urdf)
    bare = train(seeds=1, robot=str(tmp_path / "arm.urdf"))
    with refused(r"cannot be evaluated: Robot 'arm' has no drives to simulate"):
        plan_transfers(bare, "mujoco:drive=servo", load_registry())
