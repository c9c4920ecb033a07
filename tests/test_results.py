"""What an experiment's folder says, from folders made by hand."""

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

import harness
from harness.cell import Cell
from harness.choice import Choice
from harness.errors import SchemaError, UsageError
from harness.index import index_of, mean_curve, stack_runs
from harness.manifest import Manifest
from harness.plan import Plan
from harness.plugins import Registry, load_registry
from harness.results import Results, load_results
from harness.run_cell import EVALUATION, RANDOM, TRACE
from harness.store import CELLS, RESULTS, Store
from harness.trace import COLUMN, SCALARS, TraceWriter

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]
ARP = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
BASELINE_REWARDS = {0: [0, -1, -2, 3, 4], 1: [0, -2, -2, 5, 2, 9], 2: [0, -1, -1, 4, 4]}
ARP_REWARDS = {0: [0, -1, 3, 6, 4], 1: [0, -1, 2, 5, 2], 2: [0, -2, 4, 4]}


@pytest.fixture(scope="module")
def registry() -> Registry:
    """The installed plugins, their metrics above all."""
    return load_registry()


def _write_trace(path: Path, reward: Sequence[float], reached: Sequence[bool] = ()) -> None:
    """One row per reward; then one ended episode per flag, at a distance of 0.01 or 0.5 m."""
    rows = np.zeros((len(reward) + len(reached), len(SCALARS) + 2))
    rows[: len(reward), COLUMN["reward"]] = reward
    for row, is_reached in zip(rows[len(reward) :], reached, strict=True):
        row[COLUMN["step"]] = 4
        row[COLUMN["reached"]], row[COLUMN["truncated"]] = is_reached, not is_reached
        row[COLUMN["distance"]] = 0.01 if is_reached else 0.5
    with TraceWriter(path, dof=1, action_size=1) as writer:
        writer.append(rows)


def _finish(
    store: Store,
    cell: Cell,
    reward: Sequence[float],
    trained: Sequence[bool] = (True,),
    floor: Sequence[bool] = (False,),
) -> None:
    """Leave what a done cell leaves, as far as results read it."""
    folder = store.cell_folder(cell)
    folder.mkdir()
    _write_trace(folder / TRACE, reward)
    _write_trace(folder / EVALUATION, [], trained)
    _write_trace(folder / RANDOM, [], floor)
    Manifest(cell, "done", started=f"2026-01-01T00:00:0{cell.seed}+00:00", seconds=1.5).write(folder)


@pytest.fixture
def experiment(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path) -> Store:
    """Three seeds of both rewards, all done."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(3) for reward in (make_cell().reward, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        _finish(store, cell, (ARP_REWARDS if cell.reward == ARP else BASELINE_REWARDS)[cell.seed])
    return store


def _accumulated(rewards: dict[int, list[int]], seeds: Sequence[int]) -> np.ndarray:
    return stack_runs([np.array(rewards[seed], float) for seed in seeds])


def test_json_has_the_promised_keys(experiment: Store, registry: Registry):
    """What `harness report --json` promises is there, under these names, and what is added is named here."""
    data = Results(experiment.folder, registry).to_json()
    assert set(data) == {"combinations", "cells"}
    combination, cell = data["combinations"][0], data["cells"][0]
    promised = {"simulator", "algorithm", "robot", "task", "baseline", "proposed", "seeds", "eta_n", "eta_p"}
    promised |= {"baseline_index", "proposed_index", "success"}
    assert set(combination) == promised | {"steps", "behaviour"}
    assert set(combination["eta_n"]) == set(combination["eta_p"]) == {"value", "low", "high", "note"}
    for index in (combination["baseline_index"], combination["proposed_index"]):
        assert set(index) == {"first_negative", "crossover", "steps", "I_N", "I_P"}
    assert set(combination["success"]) == {"baseline", "proposed", "random"}
    assert set(cell) == {"id", "simulator", "algorithm", "reward", "seed", "status", "reason", "seconds", "steps"}


def test_json_is_strict(experiment: Store, registry: Registry):
    """No NaN, no infinity, nothing that is not plain data."""
    data = Results(experiment.folder, registry).to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_combination_is_named(experiment: Store, registry: Registry):
    """By the labels of what was chosen."""
    (combination,) = Results(experiment.folder, registry).to_json()["combinations"]
    named = {key: combination[key] for key in ("simulator", "algorithm", "robot", "task", "baseline", "proposed")}
    assert named == {
        "simulator": "ideal",
        "algorithm": "wander",
        "robot": "fd100",
        "task": "fd100-reach:horizon=5",
        "baseline": "baseline",
        "proposed": "arp",
    }
    assert combination["steps"] == 12


def test_indices_are_of_the_recorded_rewards(experiment: Store, registry: Registry):
    """Accumulated, cut to the group's shortest run, averaged; the ratios are of these."""
    (combination,) = Results(experiment.folder, registry).combinations
    baseline = index_of(mean_curve(_accumulated(BASELINE_REWARDS, (0, 1, 2))))
    proposed = index_of(mean_curve(_accumulated(ARP_REWARDS, (0, 1, 2))))
    assert (combination.baseline_index, combination.proposed_index) == (baseline, proposed)
    assert (baseline.steps, proposed.steps) == (5, 4)
    assert combination.eta_n.value == proposed.I_N / baseline.I_N
    assert combination.eta_p.value == proposed.I_P / baseline.I_P
    np.testing.assert_array_equal(combination.baseline_runs, _accumulated(BASELINE_REWARDS, (0, 1, 2)))


def test_behaviour_is_the_mean_over_seeds(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """Of the trained policies under each reward, and of random actions under both; no reward enters."""
    pairs = [(seed, name) for seed in (0, 1) for name in ("baseline", "arp")]
    cells = {(seed, name): make_cell(seed=seed, reward=Choice(name, (), name)) for seed, name in pairs}
    store = Store.create(tmp_path, make_plan(*cells.values()))
    _finish(store, cells[0, "baseline"], [1], [True, False, False, False])
    _finish(store, cells[1, "baseline"], [1], [True, True, True, False])
    _finish(store, cells[0, "arp"], [1], [True, True])
    _finish(store, cells[1, "arp"], [1], [True, True], [True, False, False, False])
    (combination,) = Results(store.folder, registry).combinations
    by_name = {item.name: item for item in combination.behaviour}
    success = by_name["success_rate"]
    assert (success.baseline, success.proposed, success.random) == (0.5, 1.0, 0.0625)
    distance = by_name["final_distance"]
    assert distance.proposed == pytest.approx(0.01)
    assert combination.to_json()["success"] == {"baseline": 0.5, "proposed": 1.0, "random": 0.0625}


def test_metric_that_is_not_defined_is_none(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Steps to the target of policies that never reach it: no number, rather than NaN."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        _finish(store, cell, [1, -3], [False])
    (combination,) = Results(store.folder, registry).combinations
    steps = next(item for item in combination.behaviour if item.name == "steps_to_target")
    assert (steps.baseline, steps.proposed, steps.random) == (None, None, None)


def test_seed_that_is_done_under_one_reward_is_left_out(experiment: Store, make_cell: MakeCell, registry: Registry):
    """Seeds are compared in pairs: the baseline's third run does not count while the proposed one failed."""
    failed = make_cell(seed=2, reward=ARP)
    experiment.record(failed, "failed", "no luck")
    (combination,) = Results(experiment.folder, registry).combinations
    assert combination.seeds == (0, 1)
    assert combination.baseline_index == index_of(mean_curve(_accumulated(BASELINE_REWARDS, (0, 1))))
    assert len(combination.baseline_runs) == len(combination.proposed_runs) == 2


def test_rows_of_both_groups_have_the_same_seed(experiment: Store, registry: Registry):
    """Whatever the order in which the cells ended, row i of both groups is of the i-th seed."""
    (combination,) = Results(experiment.folder, registry).combinations
    assert combination.seeds == (0, 1, 2)
    np.testing.assert_array_equal(combination.proposed_runs, _accumulated(ARP_REWARDS, (0, 1, 2)))


def test_combination_without_a_common_seed_says_so(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """It is listed, without numbers, and the note has the reason."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    _finish(store, cells[0], [1])
    (combination,) = Results(store.folder, registry).to_json()["combinations"]
    nothing = {"value": None, "low": None, "high": None, "note": "no seed is done under both baseline and arp"}
    assert (combination["eta_n"], combination["eta_p"]) == (nothing, nothing)
    assert (combination["baseline_index"], combination["proposed_index"], combination["seeds"]) == (None, None, [])
    assert combination["success"] == {"baseline": None, "proposed": None, "random": None}


def test_cells_are_listed_in_the_order_of_the_plan(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Each with how it ended: done, failed and skipped with the reason, pending if nothing was heard of it."""
    done, failed, pending, skipped = (make_cell(seed=seed) for seed in range(4))
    store = Store.create(tmp_path, make_plan(done, failed, pending, skipped=((skipped, "cannot"),)))
    _finish(store, done, [1])
    store.record(failed, "failed", "no luck")
    results = Results(store.folder, registry)
    assert [(cell["seed"], cell["status"], cell["reason"]) for cell in results.to_json()["cells"]] == [
        (0, "done", ""),
        (1, "failed", "no luck"),
        (2, "pending", "not run yet"),
        (3, "skipped", "cannot"),
    ]
    assert [manifest.cell for manifest in results.failed] == [failed]


def test_skipped_combination_is_not_compared(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """What cannot work is among the cells, and makes no empty row in the table."""
    buttons = Choice("buttons", (), "buttons")
    skipped = tuple((make_cell(algorithm=buttons, reward=reward), "no") for reward in (make_cell().reward, ARP))
    store = Store.create(tmp_path, make_plan(make_cell(), make_cell(reward=ARP), skipped=skipped))
    assert [item.group.algorithm.label for item in Results(store.folder, registry).combinations] == ["wander"]


def test_every_proposal_of_every_group_is_compared(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Groups differ in simulator, robot, task, algorithm or steps; their runs are never mixed."""
    strong = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")
    rewards = (make_cell().reward, ARP, strong)
    cells = [make_cell(steps=steps, reward=reward) for steps in (12, 24) for reward in rewards]
    store = Store.create(tmp_path, make_plan(*cells))
    for number, cell in enumerate(cells):
        _finish(store, cell, [-1 - number, 100])
    combinations = Results(store.folder, registry).combinations
    assert [(item.group.steps, item.proposed) for item in combinations] == [
        (12, "arp"),
        (12, "arp:k2=2"),
        (24, "arp"),
        (24, "arp:k2=2"),
    ]
    assert [item.eta_n.value for item in combinations] == [2.0, 3.0, 5 / 4, 6 / 4]


def test_table_has_a_row_per_cell(experiment: Store, make_cell: MakeCell, registry: Registry):
    """`results.parquet`: what is known of each cell, and every metric of the policy and of random actions."""
    experiment.record(make_cell(seed=2, reward=ARP), "failed", "no luck")
    results = Results(experiment.folder, registry)
    path = results.write_table()
    table = pq.read_table(path)
    metrics = sorted(results.metrics)
    assert path == experiment.folder / RESULTS
    assert table.column_names == [
        *["id", "simulator", "algorithm", "reward", "seed", "status", "reason", "seconds", "steps", "robot", "task"],
        *metrics,
        *(f"random_{name}" for name in metrics),
    ]
    assert table.num_rows == 6
    rows = {(row["reward"], row["seed"]): row for row in table.to_pylist()}
    assert rows["baseline", 0]["success_rate"] == 1.0
    assert rows["baseline", 0]["random_success_rate"] == 0.0
    assert rows["arp", 2]["success_rate"] is None
    assert rows["arp", 2]["status"] == "failed"


def test_table_of_cells_that_have_not_run(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """A metric's column is of numbers, also where there is none yet."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    schema = pq.read_schema(Results(store.folder, registry).write_table())
    assert str(schema.field("success_rate").type) == "double"


def test_damaged_trace_is_named(experiment: Store, make_cell: MakeCell, registry: Registry):
    """A file that cannot be read is an error that names it, never a number."""
    (experiment.cell_folder(make_cell()) / TRACE).write_bytes(b"PAR1")
    with pytest.raises(SchemaError, match=rf"{make_cell().id}/trace\.parquet is no readable trace"):
        _ = Results(experiment.folder, registry).combinations


def test_other_folders_are_no_results(tmp_path: Path):
    """A folder without an experiment is a usage error."""
    with pytest.raises(UsageError, match="is no experiment"):
        load_results(tmp_path)


def test_load_results_is_public(experiment: Store):
    """`harness.load_results` takes a path as text."""
    assert harness.load_results(str(experiment.folder)).baseline == "baseline"


def test_reading_results_imports_no_engine_and_unpickles_nothing(experiment: Store):
    """In a fresh process: years later, on another machine, a folder is read without what made it."""
    (experiment.folder / CELLS / ".gone.partial").mkdir()
    script = (
        "import sys, harness\n"
        "unpickled = []\n"
        "sys.addaudithook(lambda event, args: event == 'pickle.find_class' and unpickled.append(args))\n"
        "results = harness.load_results(sys.argv[1])\n"
        "assert results.to_json()['combinations'][0]['seeds'] == [0, 1, 2]\n"
        "results.write_table()\n"
        "heavy = {'torch', 'mujoco', 'stable_baselines3', 'pybullet', 'dm_control'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert not unpickled, unpickled\n"
    )
    command = [sys.executable, "-c", script, str(experiment.folder)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


def test_json_of_any_folder_can_be_printed(experiment: Store, make_cell: MakeCell, registry: Registry):
    """Also with failed cells in it."""
    experiment.record(make_cell(), "failed", 'a "quoted" reason')
    data: dict[str, Any] = Results(experiment.folder, registry).to_json()
    assert 'a \\"quoted\\" reason' in json.dumps(data)
