"""What an experiment's folder says, from folders made by hand."""

import json
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

import harness
from harness.errors import SchemaError, UsageError
from harness.eta.curve import curve_of
from harness.eta.decompose import BB, BK, KB, KK
from harness.eta.index import Index
from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, RANDOM, TRACE
from harness.record.manifest import Manifest
from harness.record.store import CELLS, RESULTS, Store
from harness.record.trace import COLUMN, SCALARS, TraceWriter
from harness.registry.choice import Choice
from harness.registry.registry import Registry, load_registry
from harness.results import Results, load_results

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]
BASELINE = Choice("baseline", (), "baseline")
ARP = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
# Distances at each step of one episode, its start first; binary fractions, so that sums are exact.
BASELINE_RUNS = {
    0: [1.0, 1.5, 1.25, 0.5, 0.25, 0.125, 0.0625],
    1: [1.0, 1.75, 1.5, 0.75, 0.5, 0.25, 0.125, 0.0],
    2: [0.5, 1.0, 0.75, 0.25, 0.125, 0.0625, 0.0],
}
ARP_RUNS = {
    0: [1.0, 1.25, 0.75, 0.25, 0.5, 0.125],
    1: [1.0, 1.5, 0.5, 0.25, 0.75, 0.0],
    2: [0.5, 1.25, 0.25, 0.125, 0.0],
}


def paid(distances: Sequence[float], k2: float = 1.0) -> list[float]:
    """What `arp` pays, worked out apart; with k2 = 1 what `baseline` pays. Nothing in the start row."""
    best, rewards = distances[0], [0.0]
    for distance in distances[1:]:
        rewards.append(-(distance - best) if distance > best else k2 * (distances[0] - distance))
        best = min(best, distance)
    return rewards


@pytest.fixture(scope="module")
def registry() -> Registry:
    """The installed plugins, their metrics above all."""
    return load_registry()


def _fail(store: Store, cell: Cell, reason: str) -> None:
    """As if the cell had failed, whatever it did."""
    store.cell_folder(cell).mkdir(exist_ok=True)
    Manifest(cell, status="failed", reason=reason).write(store.cell_folder(cell))


def _write_training(path: Path, distances: Sequence[float], rewards: Sequence[float]) -> None:
    """One unfinished episode."""
    rows = np.zeros((len(distances), len(SCALARS) + 2))
    best = np.minimum.accumulate([distances[0], *distances])[:-1]
    rows[:, COLUMN["step"]] = np.arange(len(rows))
    rows[:, COLUMN["begin_distance"]], rows[:, COLUMN["previous_best"]] = distances[0], best
    rows[:, COLUMN["distance"]], rows[:, COLUMN["reward"]] = distances, rewards
    _write(path, rows)


def _write_evaluation(path: Path, reached: Sequence[bool]) -> None:
    """One ended episode per flag, at a distance of 0.01 or 0.5 m."""
    rows = np.zeros((len(reached), len(SCALARS) + 2))
    for number, (row, is_reached) in enumerate(zip(rows, reached, strict=True)):
        row[COLUMN["env"]], row[COLUMN["step"]] = number, 4
        row[COLUMN["reached"]] = row[COLUMN["terminated"]] = is_reached
        row[COLUMN["truncated"]] = not is_reached
        row[COLUMN["distance"]] = 0.01 if is_reached else 0.5
    _write(path, rows)


def _write(path: Path, rows: np.ndarray) -> None:
    with TraceWriter(path, dof=1, action_size=1) as writer:
        writer.append(rows)


def _finish(
    store: Store,
    cell: Cell,
    distances: Sequence[float],
    trained: Sequence[bool] = (True,),
    floor: Sequence[bool] = (False,),
    rewards: Sequence[float] | None = None,
) -> None:
    """Leave what a done cell leaves, as far as results read it."""
    if rewards is None:
        rewards = paid(distances, dict(cell.reward.params).get("k2", 1.0))
    folder = store.cell_folder(cell)
    folder.mkdir()
    _write_training(folder / TRACE, distances, rewards)
    _write_evaluation(folder / EVALUATION, trained)
    _write_evaluation(folder / RANDOM, floor)
    Manifest(cell, status="done", started=f"2026-01-01T00:00:0{cell.seed}+00:00", seconds=1.5).write(folder)


@pytest.fixture
def experiment(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path) -> Store:
    """Three seeds of both rewards, all done."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(3) for reward in (make_cell().reward, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        _finish(store, cell, (ARP_RUNS if cell.reward == ARP else BASELINE_RUNS)[cell.seed])
    return store


def _index(runs: Mapping[int, Sequence[float]], k2: float = 1.0, seeds: Sequence[int] = (0, 1, 2)) -> Index:
    """Of these runs under `arp`, or under `baseline`."""
    return curve_of([np.array(paid(runs[seed], k2)) for seed in seeds]).index


def _one(results: Results) -> Any:
    """The one combination."""
    (combination,) = results.combinations
    return combination


def test_json_has_the_promised_keys(experiment: Store, registry: Registry):
    """What `harness report --json` promises is there, under these names, and what is added is named here."""
    data = Results(experiment.folder, registry).to_json()
    assert set(data) == {"combinations", "cells"}
    combination, cell = data["combinations"][0], data["cells"][0]
    promised = {"simulator", "algorithm", "robot", "task", "baseline", "proposed", "seeds", "eta_n", "eta_p"}
    promised |= {"baseline_index", "proposed_index", "success"}
    promised |= {"ruler_n", "behaviour_n", "ruler_p", "behaviour_p"}
    added = {"steps", "deterministic", "behaviour", "other_path", "verdict", "basis", "p_corrected"}
    added |= {f"{name}_{letter}" for name in ("noise", "paths_disagree", "p", "seeds_needed") for letter in "np"}
    assert set(combination) == promised | added
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
    """Accumulated, cut to the group's shortest run, averaged; the ratios are of these, not rounded."""
    combination = _one(Results(experiment.folder, registry))
    baseline, proposed = _index(BASELINE_RUNS), _index(ARP_RUNS, 1.5)
    assert (combination.baseline_index, combination.proposed_index) == (baseline, proposed)
    assert (baseline.steps, proposed.steps) == (7, 5)
    assert combination.eta_n.value == proposed.negative_sum / baseline.negative_sum
    assert combination.eta_p.value == proposed.positive_sum / baseline.positive_sum


def test_runs_are_scored_under_the_other_reward(experiment: Store, registry: Registry):
    """Ruler and behaviour are those of the four scored groups, on both paths."""
    combination = _one(Results(experiment.folder, registry))
    bb, bk = _index(BASELINE_RUNS), _index(ARP_RUNS)
    kb, kk = _index(BASELINE_RUNS, 1.5), _index(ARP_RUNS, 1.5)
    split = combination.decomposition.positive
    assert split.ruler.value == kk.positive_sum / bk.positive_sum
    assert split.behaviour.value == bk.positive_sum / bb.positive_sum
    assert split.other_ruler.value == kb.positive_sum / bb.positive_sum
    assert split.other_behaviour.value == kk.positive_sum / kb.positive_sum


def test_behaviour_is_the_mean_over_seeds(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """Of the trained policies under each reward, and of random actions under both; no reward enters."""
    pairs = [(seed, name) for seed in (0, 1) for name in ("baseline", "arp")]
    cells = {(seed, name): make_cell(seed=seed, reward=Choice(name, (), name)) for seed, name in pairs}
    store = Store.create(tmp_path, make_plan(*cells.values()))
    _finish(store, cells[0, "baseline"], [1.0, 0.5], [True, False, False, False])
    _finish(store, cells[1, "baseline"], [1.0, 0.5], [True, True, True, False])
    _finish(store, cells[0, "arp"], [1.0, 0.5], [True, True])
    _finish(store, cells[1, "arp"], [1.0, 0.5], [True, True], [True, False, False, False])
    combination = _one(Results(store.folder, registry))
    by_name = {change.name: change for change in combination.changes}
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
        _finish(store, cell, [1.0, 1.5], [False])
    changes = _one(Results(store.folder, registry)).changes
    steps = next(change for change in changes if change.name == "steps_to_target")
    assert (steps.baseline, steps.proposed, steps.random) == (None, None, None)


def test_seed_that_is_done_under_one_reward_is_left_out(experiment: Store, make_cell: MakeCell, registry: Registry):
    """Seeds are compared in pairs: the baseline's third run does not count while the proposed one failed."""
    failed = make_cell(seed=2, reward=ARP)
    _fail(experiment, failed, "no luck")
    combination = _one(Results(experiment.folder, registry))
    assert combination.seeds == (0, 1)
    assert combination.baseline_index == _index(BASELINE_RUNS, seeds=(0, 1))
    assert {curve.count for curve in combination.curves.values()} == {2}
    assert {change.seeds for change in combination.changes if change.name == "success_rate"} == {2}


def test_rows_of_both_groups_have_the_same_seed(experiment: Store, registry: Registry):
    """Whatever the order in which the cells ended, row i of both groups is of the i-th seed."""
    combination = _one(Results(experiment.folder, registry))
    assert combination.seeds == (0, 1, 2)
    for pair, runs, k2 in (
        (BB, BASELINE_RUNS, 1.0),
        (KB, BASELINE_RUNS, 1.5),
        (KK, ARP_RUNS, 1.5),
        (BK, ARP_RUNS, 1.0),
    ):
        steps = min(map(len, runs.values()))
        expected = [np.cumsum(paid(runs[seed], k2))[:steps] for seed in (0, 1, 2)]
        np.testing.assert_array_equal(combination.curves[pair].runs, expected)


def test_combination_without_a_common_seed_says_so(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """It is listed, without numbers, and the note has the reason."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    _finish(store, cells[0], [1.0, 0.5])
    results = Results(store.folder, registry)
    (combination,) = results.to_json()["combinations"]
    nothing = {"value": None, "low": None, "high": None, "note": "no seed is done under both baseline and arp"}
    assert (combination["eta_n"], combination["eta_p"]) == (nothing, nothing)
    assert (combination["baseline_index"], combination["proposed_index"], combination["seeds"]) == (None, None, [])
    assert combination["success"] == {"baseline": None, "proposed": None, "random": None}
    assert combination["ruler_p"] == combination["other_path"]["behaviour_n"] == nothing
    assert (combination["behaviour"], combination["basis"]) == ([], "")
    assert combination["verdict"] == "Nothing to compare: no seed is done under both baseline and arp."
    assert _one(results).curves == {}


def test_json_of_a_combination_always_has_the_same_keys(
    experiment: Store, make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Also where there is nothing to compare."""
    store = Store.create(tmp_path / "other", make_plan(make_cell(), make_cell(reward=ARP)))
    (full,), (empty,) = (Results(one.folder, registry).to_json()["combinations"] for one in (experiment, store))
    assert list(empty) == list(full)
    assert json.dumps(empty, allow_nan=False)


def test_cells_are_listed_in_the_order_of_the_plan(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Each with how it ended: done, failed and skipped with the reason, pending if nothing was heard of it."""
    done, failed, pending, skipped = (make_cell(seed=seed) for seed in range(4))
    store = Store.create(tmp_path, make_plan(done, failed, pending, skipped=((skipped, "cannot"),)))
    _finish(store, done, [1.0, 0.5])
    _fail(store, failed, "no luck")
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
        _finish(store, cell, [1.0, 2.0 + number])  # I_N is -1 - number
    combinations = Results(store.folder, registry).combinations
    assert [(item.group.steps, item.proposed) for item in combinations] == [
        (12, "arp"),
        (12, "arp:k2=2"),
        (24, "arp"),
        (24, "arp:k2=2"),
    ]
    assert [item.eta_n.value for item in combinations] == [2.0, 3.0, 5 / 4, 6 / 4]


def test_numbers_of_evaluation_episodes_are_not_mixed(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Evaluations of other length are another group, in the same folder."""
    cells = [make_cell(evaluation_episodes=count, reward=reward) for count in (2, 4) for reward in (BASELINE, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        _finish(store, cell, [1.0, 2.0], [True] * cell.evaluation_episodes)
    combinations = Results(store.folder, registry).combinations
    assert [item.group.evaluation_episodes for item in combinations] == [2, 4]
    assert ["4 evaluation episodes" in item.basis for item in combinations] == [False, True]


def test_reward_against_itself_is_compared_where_it_was_asked_for(
    make_cell: MakeCell, registry: Registry, tmp_path: Path
):
    """A/A: the baseline among the proposed rewards gives 1 throughout, with nothing left to chance."""
    cells = [make_cell(seed=seed) for seed in range(3)]
    for name, asked in (("with", True), ("without", False)):
        store = Store.create(tmp_path / name, Plan("baseline", tuple(cells), (), {}, a_a=asked))
        for cell in cells:
            _finish(store, cell, BASELINE_RUNS[cell.seed])
        combinations = Results(store.folder, registry).combinations
        assert len(combinations) == asked
        for combination in combinations:
            eta = combination.eta_p
            assert (combination.baseline, combination.proposed) == ("baseline", "baseline")
            assert (eta.value, eta.low, eta.high) == (1.0, 1.0, 1.0)


# Rewards that cannot score


def _nothing_is_split(combination: Any, reason: str) -> None:
    """Eta and behaviour stand, and each part says why it does not."""
    assert combination.eta_p.value is not None
    assert combination.eta_p.low is not None
    assert combination.success.baseline == 1.0
    for split in (combination.decomposition.negative, combination.decomposition.positive):
        for part in (split.ruler, split.behaviour, split.other_ruler, split.other_behaviour):
            assert part.value is None
            assert reason in part.note
    assert set(combination.curves) == {BB, KK}
    assert f"not split, {split.ruler.note}." in combination.verdict
    assert json.dumps(combination.to_json(), allow_nan=False)


@pytest.mark.parametrize("gone", ["baseline", "proposed"])
def test_reward_that_is_not_installed_any_more(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path, gone: str
):
    """What it paid is recorded: only the split is missing, with the reason."""
    lost = Choice("lost", (), "lost")
    baseline, proposed = (lost, ARP) if gone == "baseline" else (BASELINE, lost)
    cells = [make_cell(seed=seed, reward=reward) for seed in range(3) for reward in (baseline, proposed)]
    store = Store.create(tmp_path, make_plan(*cells, baseline=baseline.label))
    for cell in cells:
        _finish(store, cell, BASELINE_RUNS[cell.seed])
    _nothing_is_split(_one(Results(store.folder, registry)), "No reward 'lost'")


@pytest.mark.parametrize("changed", ["baseline", "arp"])
def test_reward_that_has_changed(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path, changed: str
):
    """One that does not pay its own recorded steps as then cannot tell what it would have paid the others."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(3) for reward in (BASELINE, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        rewards = np.array(paid(BASELINE_RUNS[cell.seed], 1.5 if cell.reward == ARP else 1.0))
        if cell.reward.label == changed:
            rewards[1] *= 1.001
        _finish(store, cell, BASELINE_RUNS[cell.seed], rewards=rewards)
    reason = f"reward {changed} pays its own recorded steps otherwise than then: it has changed"
    _nothing_is_split(_one(Results(store.folder, registry)), reason)


def test_last_bits_are_no_change_of_a_reward(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Another machine's numbers may differ in them, and the folder is still read."""
    cells = [make_cell(reward=reward) for reward in (BASELINE, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        rewards = np.nextafter(paid(BASELINE_RUNS[0], 1.5 if cell.reward == ARP else 1.0), 10.0)
        _finish(store, cell, BASELINE_RUNS[0], rewards=rewards)
    assert _one(Results(store.folder, registry)).decomposition.positive.ruler.value is not None


BROKEN = """
from dataclasses import dataclass
import numpy as np
import harness

@harness.hookimpl
def register_rewards(register):
    register("broken", f"{__name__}:Broken", summary="does something wrong beyond a distance")

@dataclass(frozen=True)
class Broken:
    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        if (sample.distance > 1.6).any():
            DO
        return carry, -sample.distance
"""


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ("raise ZeroDivisionError('by\\nnothing')", "a reward could not score the runs: ZeroDivisionError: by nothing"),
        ("return carry, np.full_like(sample.distance, np.nan)", "reward broken is not finite on the runs of another"),
    ],
)
def test_reward_that_fails_on_other_runs(
    make_cell: MakeCell,
    make_plan: MakePlan,
    write_plugin: Callable[..., EntryPoint],
    tmp_path: Path,
    wrong: str,
    reason: str,
):
    """A plugin may do anything with motion that it never paid for: that costs the split alone."""
    registry = load_registry([*entry_points(group="harness"), write_plugin(BROKEN.replace("DO", wrong), "broken")])
    cells = [
        make_cell(seed=seed, reward=reward)
        for seed in range(3)
        for reward in (BASELINE, Choice("broken", (), "broken"))
    ]
    store = Store.create(tmp_path / "experiment", make_plan(*cells))
    for cell in cells:
        runs = BASELINE_RUNS if cell.reward == BASELINE else ARP_RUNS
        own = None if cell.reward == BASELINE else [0.0, *(-distance for distance in ARP_RUNS[cell.seed][1:])]
        _finish(store, cell, [*runs[cell.seed][:3], 0.5, 0.0], rewards=own and [*own[:3], -0.5, 0.0])
    results = Results(store.folder, registry)
    combination = _one(results)
    assert combination.eta_n.value is not None
    assert reason in combination.decomposition.negative.ruler.note
    assert json.dumps(results.to_json(), allow_nan=False)


# Several comparisons


def _p_value(combination: Any, name: str) -> float:
    """Before correction."""
    split = combination.decomposition
    return {"eta_n": split.negative.p, "eta_p": split.positive.p, "success": combination.success.p}[name]


def test_p_values_are_corrected_over_all_combinations(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Holm's correction of each of eta_N, eta_P and success, over the combinations of the folder that have one."""
    strong = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")
    lonely = Choice("arp", (("k1", 1.0), ("k2", 4.0)), "arp:k2=4")
    cells = [make_cell(seed=seed, reward=reward) for seed in range(6) for reward in (BASELINE, ARP, strong)]
    store = Store.create(tmp_path, make_plan(*cells, make_cell(reward=lonely)))
    for cell in cells:
        good = {"baseline": cell.seed % 2 == 0, "arp": cell.seed != 3, "arp:k2=2": True}[cell.reward.label]
        _finish(store, cell, (BASELINE_RUNS if cell.reward == BASELINE else ARP_RUNS)[cell.seed % 3], [good, True])
    one, two, none = Results(store.folder, registry).combinations
    for name in ("eta_n", "eta_p", "success"):
        raw = [_p_value(combination, name) for combination in (one, two)]
        small, large = sorted(raw)
        expected = {large: min(1.0, max(2 * small, large)), small: min(1.0, 2 * small)}
        assert [one.corrected[name], two.corrected[name]] == [expected[p] for p in raw]
        assert none.corrected[name] is None
    assert one.to_json()["p_corrected"] == dict(one.corrected)


def test_table_has_a_row_per_cell(experiment: Store, make_cell: MakeCell, registry: Registry):
    """`results.parquet`: what is known of each cell, and every metric of the policy and of random actions."""
    _fail(experiment, make_cell(seed=2, reward=ARP), "no luck")
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
    _fail(experiment, make_cell(), 'a "quoted" reason')
    data: dict[str, Any] = Results(experiment.folder, registry).to_json()
    assert 'a \\"quoted\\" reason' in json.dumps(data)
