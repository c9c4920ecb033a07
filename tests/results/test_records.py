"""What the cells of a folder left."""

import pyarrow.parquet as pq
import pytest

from harness import load_results
from harness.experiment.plan import Plan
from harness.record.cell import BROUGHT
from harness.registry import Choice
from harness.report.rows.comparison import remarks_on_cells
from tests.results.folders import ARP, fail
from tests.stores import create_store


def test_cells_are_listed_in_the_order_of_the_plan(make_cell, made):
    """Each with how it ended: done, failed and skipped with the reason, pending if nothing was heard of it."""
    *cells, skipped = (make_cell(seed=seed) for seed in range(4))
    results = made(cells, lambda cell: None if cell.seed else {}, skipped=((skipped, "cannot"),))
    fail(results.store, cells[1], "no luck")
    results = load_results(results.folder)
    assert [(cell["seed"], cell["status"], cell["reason"]) for cell in results.to_json()["cells"]] == [
        (0, "done", ""),
        (1, "failed", "no luck"),
        (2, "pending", "not run yet"),
        (3, "skipped", "cannot"),
    ]
    assert [manifest.cell for manifest in results.failed] == [cells[1]]


@pytest.fixture(name="controlled")
def _controlled(both, make_cell, made):
    """Seeds 0 and 1 of both rewards, and the baseline again with 2 and 3."""
    return made([*both(2), make_cell(seed=2), make_cell(seed=3)], control={0: 2, 1: 3})


def test_cells_of_the_null_control_are_done_and_left_out(controlled):
    """They are no run of the experiment's own question."""
    assert [manifest.cell.seed for manifest in controlled.done] == [0, 0, 1, 1, 2, 3]
    assert [cell.seed for cell in controlled.done_cells] == [0, 0, 1, 1]


def test_control_is_told_by_reward_and_seed(controlled, make_cell):
    """Neither alone is enough."""
    told = [controlled.is_control(make_cell(**of)) for of in ({"seed": 2}, {"seed": 2, "reward": ARP}, {"seed": 1})]
    assert told == [True, False, False]


def test_seed_of_the_experiment_is_no_control(make_cell, made):
    """Also where another seed's control has it."""
    cells = [make_cell(seed=seed) for seed in (0, 1, 2)]
    records = made(cells, lambda cell: None, control={0: 1, 1: 2})
    assert list(map(records.is_control, cells)) == [False, False, True]


def test_cell_is_measured_once(controlled, make_cell):
    """Reading a trace takes longest."""
    assert controlled.measured(make_cell()).manners is controlled.measured(make_cell()).manners
    assert controlled.moments(make_cell()) is controlled.moments(make_cell())


def test_no_metric_is_of_an_environment(make_cell, make_plan, tmp_path):
    """They look at an arm; nothing is compared by traces, and the table has the cell, which failed."""
    cell = make_cell(simulator=BROUGHT.simulator, robot=BROUGHT.robot, task=Choice("pendulum", (), "pendulum"))
    create_store(tmp_path, make_plan(cell)).record(cell, "failed", "it fell")
    results = load_results(tmp_path)
    assert results.metrics == results.not_measured == {}
    assert results.combinations == ()
    assert [cell["reason"] for cell in results.to_json()["cells"]] == ["it fell"]
    assert pq.read_table(results.write_table()).num_rows == 1


def test_the_experiment_of_version_0_1_is_its_file(make_cell, tmp_path):
    """Plans of then do not hold it."""
    create_store(tmp_path, Plan("baseline", (make_cell(),), (), {}, {}))
    (tmp_path / "experiment.toml").write_text('sim = "mujoco"\n')
    assert load_results(tmp_path).experiment_text == 'sim = "mujoco"\n'


def test_trainings_that_left_the_same_trace_are_told(both, make_cell, made):
    """Of one combination: another task may give the same trace by itself."""
    cells = [*both(2, (make_cell().reward, Choice("copy", (), "copy"))), make_cell(steps=99)]
    results = made(cells, lambda cell: {"distances": [1.0, 0.5 + 0.1 * cell.seed]})
    ((group, equal),) = results.equal.items()
    assert group.steps == cells[0].steps
    assert equal == tuple((("baseline", seed), ("copy", seed)) for seed in (0, 1))
    told = results.to_json()["equal_trainings"]
    assert [it["trainings"][1] for it in told] == [{"trained_by": "copy", "seed": seed} for seed in (0, 1)]
    assert remarks_on_cells(results)[-1] == (
        f"{group.title}: The trainings by baseline and copy are equal bit for bit, with seeds 0 and 1: between them "
        "there is nothing to compare."
    )


def test_trainings_that_differ_are_not_told(experiment):
    """As nearly all do."""
    assert (experiment.equal, experiment.to_json()["equal_trainings"], remarks_on_cells(experiment)) == ({}, [], [])
