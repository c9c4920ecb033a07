"""Jobs in this process, in a process that did others before, and in one of their own: the same bytes."""

import pytest

from harness.executor import CellOptions, Job, Limits, run_job, run_jobs
from harness.experiment.jobs import order_of
from harness.experiment.plan import check_experiment, expand
from harness.experiment.workers.order import read_order
from harness.record import EVALUATION, POLICY, TRACE
from tests.registered import REGISTRY

QUICK = {"sim": "kinematic", "algo": "random,sac-fast", "reward": "arp", "seeds": 1, "steps": 320}
QUICK |= {"evaluation_episodes": 2}
ALL = {**QUICK, "sim": "kinematic,mujoco,pybullet,dm_control", "algo": "sb3-sac,sac-fast,ppo,td3", "steps": 400}
RESULTS = (TRACE, EVALUATION, f"{POLICY}/weights.safetensors")


def _cells(experiment):
    return expand(check_experiment(experiment), REGISTRY).cells


def _left(cells, folder, options):
    """What cells leave that processes did, one after the other, by the cell and the file."""
    events = []
    run_jobs([Job(cell, folder / cell.id, options) for cell in cells], 1, events.append)
    assert sum(event.kind == "ended" for event in events) == len(cells)
    assert not [event.reason for event in events if event.reason]
    paths = [folder / cell.id / name for cell in cells for name in RESULTS]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths if path.exists()}


@pytest.mark.parametrize("experiment", [QUICK, pytest.param(ALL, marks=pytest.mark.slow)], ids=["quick", "all"])
def test_a_process_that_did_other_cells_does_the_same(experiment, tmp_path):
    """Byte for byte what a process of its own does: nothing of an earlier cell stays behind."""
    cells = _cells(experiment)
    warm = _left(cells, tmp_path / "warm", CellOptions())
    assert len(warm) >= 2 * len(cells)
    assert warm == _left(cells, tmp_path / "fresh", CellOptions(fresh=True))


def test_a_job_in_this_process_does_the_same(tmp_path):
    """For executors that start processes themselves."""
    cell = _cells(QUICK)[0]
    assert run_job(Job(cell, tmp_path / "here")).status == "done"
    assert _left((cell,), tmp_path, CellOptions())[f"{cell.id}/{TRACE}"] == (tmp_path / "here" / TRACE).read_bytes()


def test_the_order_of_a_job_holds_all_of_it(tmp_path):
    """Cell, folder and options come back from the line."""
    job = Job(_cells(QUICK)[0], tmp_path / "cell", CellOptions(limits=Limits(stall_after=3.0), floor=False))
    order, _ = read_order(order_of(job).line())
    assert (order.folder, order.work.cell, order.work.options) == (job.folder, job.cell, job.options)


def test_a_job_is_read_as_it_was_told(tmp_path):
    """As JSON, on another machine."""
    job = Job(_cells(QUICK)[0], tmp_path / "cell", CellOptions(100, limits=Limits(cell_memory=2.0)))
    assert Job.from_json(job.to_json()) == job
