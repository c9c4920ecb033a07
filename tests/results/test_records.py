"""What the cells of a folder left."""

from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from harness.experiment.plan import Plan
from harness.record.cell import BROUGHT, Cell
from harness.record.plan_file import EXPERIMENT
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.report.rows.comparison import remarks_on_cells
from harness.results import Results
from harness.results.load import read_results
from tests.results.folders import ARP, fail, finish

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]


def test_cells_are_listed_in_the_order_of_the_plan(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Each with how it ended: done, failed and skipped with the reason, pending if nothing was heard of it."""
    done, failed, pending, skipped = (make_cell(seed=seed) for seed in range(4))
    store = Store.create(tmp_path, make_plan(done, failed, pending, skipped=((skipped, "cannot"),)))
    finish(store, done, [1.0, 0.5])
    fail(store, failed, "no luck")
    results = Results(store.folder, registry)
    assert [(cell["seed"], cell["status"], cell["reason"]) for cell in results.to_json()["cells"]] == [
        (0, "done", ""),
        (1, "failed", "no luck"),
        (2, "pending", "not run yet"),
        (3, "skipped", "cannot"),
    ]
    assert [manifest.cell for manifest in results.failed] == [failed]


@pytest.fixture(name="controlled")
def _controlled(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path) -> Results:
    """Seeds 0 and 1 of both rewards, and the baseline again with 2 and 3."""
    cells = [make_cell(seed=seed, reward=reward) for seed in (0, 1) for reward in (make_cell().reward, ARP)]
    cells += [make_cell(seed=seed) for seed in (2, 3)]
    store = Store.create(tmp_path, make_plan(*cells, control={0: 2, 1: 3}))
    for cell in cells:
        finish(store, cell, [1.0, 0.5])
    return Results(store.folder, registry)


def test_cells_of_the_null_control_are_done_and_left_out(controlled: Results):
    """They are no run of the experiment's own question."""
    assert [manifest.cell.seed for manifest in controlled.done] == [0, 0, 1, 1, 2, 3]
    assert [cell.seed for cell in controlled.done_cells] == [0, 0, 1, 1]


def test_control_is_told_by_reward_and_seed(controlled: Results, make_cell: MakeCell):
    """Neither alone is enough."""
    assert controlled.is_control(make_cell(seed=2))
    assert not controlled.is_control(make_cell(seed=2, reward=ARP))
    assert not controlled.is_control(make_cell(seed=1))


def test_seed_of_the_experiment_is_no_control(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Also where another seed's control has it."""
    store = Store.create(tmp_path, make_plan(*(make_cell(seed=seed) for seed in (0, 1, 2)), control={0: 1, 1: 2}))
    records = Results(store.folder, registry)
    assert [records.is_control(make_cell(seed=seed)) for seed in (0, 1, 2)] == [False, False, True]


def test_cell_is_measured_once(controlled: Results, make_cell: MakeCell):
    """Reading a trace takes longest."""
    assert controlled.measured(make_cell()) is controlled.measured(make_cell())
    assert controlled.moments(make_cell()) is controlled.moments(make_cell())


@pytest.fixture
def in_environment(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path) -> Results:
    """A cell in an environment of anybody; it failed."""
    cell = make_cell(simulator=BROUGHT.simulator, robot=BROUGHT.robot, task=Choice("pendulum", (), "pendulum"))
    store = Store.create(tmp_path, make_plan(cell))
    store.record(cell, "failed", "it fell")
    return read_results(tmp_path, registry)


def test_no_metric_is_of_an_environment(in_environment: Results):
    """They look at an arm; nothing is compared by traces, and the table has the cell."""
    assert in_environment.metrics == in_environment.not_measured == {}
    assert in_environment.combinations == ()
    assert [cell["reason"] for cell in in_environment.to_json()["cells"]] == ["it fell"]
    assert pq.read_table(in_environment.write_table()).num_rows == 1


def test_the_experiment_of_version_0_1_is_its_file(make_cell: MakeCell, registry: Registry, tmp_path: Path):
    """Plans of then do not hold it."""
    Store.create(tmp_path, Plan("baseline", (make_cell(),), (), {}, {}))
    (tmp_path / EXPERIMENT).write_text('sim = "mujoco"\n')
    assert Results(tmp_path, registry).experiment_text == 'sim = "mujoco"\n'


def test_trainings_that_left_the_same_trace_are_told(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Of one combination: another task may give the same trace by itself."""
    copy = Choice("copy", (), "copy")
    cells = [make_cell(seed=seed, reward=reward) for seed in (0, 1) for reward in (make_cell().reward, copy)]
    cells.append(make_cell(steps=99))
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, [1.0, 0.5 + 0.1 * cell.seed])
    results = Results(store.folder, registry)
    ((group, equal),) = results.equal.items()
    assert group.steps == cells[0].steps
    assert equal == tuple((("baseline", seed), ("copy", seed)) for seed in (0, 1))
    told = results.to_json()["equal_trainings"]
    assert [it["trainings"][1] for it in told] == [{"trained_by": "copy", "seed": seed} for seed in (0, 1)]
    assert remarks_on_cells(results)[-1] == (
        f"{group.title}: The trainings by baseline and copy are equal bit for bit, with seeds 0 and 1: between them "
        "there is nothing to compare."
    )


def test_trainings_that_differ_are_not_told(experiment: Store, registry: Registry):
    """As nearly all do."""
    results = Results(experiment.folder, registry)
    assert (results.equal, results.to_json()["equal_trainings"], remarks_on_cells(results)) == ({}, [], [])
