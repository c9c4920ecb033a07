"""From an experiment's records to its comparisons, from folders made by hand."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.eta.behaviour_change import Change
from harness.eta.curve import curve_of
from harness.eta.index import Index
from harness.eta.scored_sums import BB, BK, KB, KK
from harness.eta.swaps import corrected_p
from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry, load_registry
from harness.results import Results
from harness.results.comparison import Comparison
from tests.results.folders import ARP, ARP_RUNS, BASELINE, BASELINE_RUNS, fail, finish, only, paid

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]
STRONG = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")


def _index(runs: Mapping[int, Sequence[float]], k2: float = 1.0, seeds: Sequence[int] = (0, 1, 2)) -> Index:
    """Of these runs under `arp`, or under `baseline`."""
    return curve_of([np.array(paid(runs[seed], k2)) for seed in seeds]).index


def test_indices_are_of_the_recorded_rewards(experiment: Store, registry: Registry):
    """Accumulated, cut to the group's shortest run, averaged; the ratios are of these, not rounded."""
    combination = only(Results(experiment.folder, registry))
    baseline, proposed = _index(BASELINE_RUNS), _index(ARP_RUNS, 1.5)
    assert (combination.number.decomposition.baseline, combination.number.decomposition.proposed) == (
        baseline,
        proposed,
    )
    assert (baseline.steps, proposed.steps) == (7, 5)
    assert combination.number.eta_n.value == proposed.negative_sum / baseline.negative_sum
    assert combination.number.eta_p.value == proposed.positive_sum / baseline.positive_sum


def test_runs_are_scored_under_the_other_reward(experiment: Store, registry: Registry):
    """Ruler and behaviour are those of the four scored groups, on both paths."""
    combination = only(Results(experiment.folder, registry))
    bb, bk = _index(BASELINE_RUNS), _index(ARP_RUNS)
    kb, kk = _index(BASELINE_RUNS, 1.5), _index(ARP_RUNS, 1.5)
    first, second = combination.number.decomposition.positive.paths
    assert first.ruler.value == kk.positive_sum / bk.positive_sum
    assert first.behaviour.value == bk.positive_sum / bb.positive_sum
    assert second.ruler.value == kb.positive_sum / bb.positive_sum
    assert second.behaviour.value == kk.positive_sum / kb.positive_sum


def test_behaviour_is_the_mean_over_seeds(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """Of the trained policies under each reward, and of random actions under both; no reward enters."""
    pairs = [(seed, name) for seed in (0, 1) for name in ("baseline", "arp")]
    cells = {(seed, name): make_cell(seed=seed, reward=Choice(name, (), name)) for seed, name in pairs}
    store = Store.create(tmp_path, make_plan(*cells.values()))
    finish(store, cells[0, "baseline"], [1.0, 0.5], [True, False, False, False])
    finish(store, cells[1, "baseline"], [1.0, 0.5], [True, True, True, False])
    finish(store, cells[0, "arp"], [1.0, 0.5], [True, True])
    finish(store, cells[1, "arp"], [1.0, 0.5], [True, True], [True, False, False, False])
    combination = only(Results(store.folder, registry))
    by_name = {change.name: change for change in combination.measured.changes_of("deterministic")}
    success = by_name["success_rate"]
    assert (success.baseline, success.proposed, success.random) == (0.5, 1.0, 0.0625)
    distance = by_name["final_distance"]
    assert distance.proposed == pytest.approx(0.01)


def test_metric_that_is_not_defined_is_none(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Steps to the target of policies that never reach it: no number, rather than NaN."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, [1.0, 1.5], [False])
    changes = only(Results(store.folder, registry)).measured.changes
    steps = next(change for change in changes if change.name == "steps_to_target")
    assert (steps.baseline, steps.proposed, steps.random) == (None, None, None)


def test_seed_that_is_done_under_one_reward_is_left_out(experiment: Store, make_cell: MakeCell, registry: Registry):
    """Seeds are compared in pairs: the baseline's third run does not count while the proposed one failed."""
    failed = make_cell(seed=2, reward=ARP)
    fail(experiment, failed, "no luck")
    combination = only(Results(experiment.folder, registry))
    assert combination.seeds == (0, 1)
    assert combination.number.decomposition.baseline == _index(BASELINE_RUNS, seeds=(0, 1))
    assert {curve.count for curve in combination.curves.values()} == {2}
    assert combination.decisive.seeds == 2


def test_rows_of_both_groups_have_the_same_seed(experiment: Store, registry: Registry):
    """Whatever the order in which the cells ended, row i of both groups is of the i-th seed."""
    combination = only(Results(experiment.folder, registry))
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


def test_combination_without_a_training_of_one_reward_says_so(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """It is listed, without numbers, and the note has the reason."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    finish(store, cells[0], [1.0, 0.5])
    results = Results(store.folder, registry)
    (combination,) = results.to_json()["combinations"]
    reason = "no training with arp is done"
    nothing = {"value": None, "low": None, "high": None, "note": reason}
    assert combination["eta_N"]["eta"] == combination["eta_P"]["behaviour"] == nothing
    assert (combination["baseline_index"], combination["proposed_index"], combination["seeds"]) == (None, None, [])
    assert (combination["behaviour"], combination["total"]) == ([], None)
    assert combination["headline"]["robot"] == f"Nothing to compare: {reason}."
    assert only(results).curves == {}


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
        finish(store, cell, [1.0, 2.0 + number])  # I_N is -1 - number
    combinations = Results(store.folder, registry).combinations
    assert [(item.group.steps, item.proposed) for item in combinations] == [
        (12, "arp"),
        (12, "arp:k2=2"),
        (24, "arp"),
        (24, "arp:k2=2"),
    ]
    assert [item.number.eta_n.value for item in combinations] == [2.0, 3.0, 5 / 4, 6 / 4]


def test_numbers_of_evaluation_episodes_are_not_mixed(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Evaluations of other length are another group, in the same folder."""
    cells = [make_cell(evaluation_episodes=count, reward=reward) for count in (2, 4) for reward in (BASELINE, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, [1.0, 2.0], [True] * cell.evaluation_episodes)
    combinations = Results(store.folder, registry).combinations
    assert [item.group.evaluation_episodes for item in combinations] == [2, 4]
    assert [item.measured.episodes["deterministic"] for item in combinations] == [2, 4]


# The null control


@pytest.fixture(name="controlled")
def _controlled(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path) -> Results:
    """Seeds 0 to 5 of both rewards, and the baseline again with 6 to 11."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(6) for reward in (BASELINE, ARP)]
    again = [make_cell(seed=seed) for seed in range(6, 12)]
    store = Store.create(tmp_path, make_plan(*cells, *again, control={seed: seed + 6 for seed in range(6)}))
    for cell in (*cells, *again):
        runs = ARP_RUNS if cell.reward == ARP else BASELINE_RUNS
        finish(store, cell, runs[cell.seed % 3], [True, cell.reward == ARP], learned={5: [True]})
    return Results(store.folder, registry)


def test_null_control_compares_a_seed_with_another_one(controlled: Results):
    """Both groups are the baseline's, and none of their runs is the same; it comes last."""
    asked, control = controlled.combinations
    assert (asked.is_control, control.is_control) == (False, True)
    assert (control.baseline, control.proposed, control.seeds) == ("baseline", "baseline", (0, 1, 2, 3, 4, 5))
    # Seeds 6 to 11 repeat the runs of 0 to 5 here: as good a training gives 1 everywhere.
    assert [control.number.splits[name].eta.value for name in ("eta_N", "eta_P")] == [1.0, 1.0]


def test_null_control_runs_are_no_runs_of_the_question(controlled: Results):
    """The other comparisons have their own seeds alone."""
    assert controlled.combinations[0].seeds == (0, 1, 2, 3, 4, 5)


def test_null_control_is_the_noise_floor(controlled: Results):
    """Halves of all runs of the baseline stand for what seeds do."""
    note = controlled.combinations[0].number.decomposition.positive.noise.note
    assert note == "the baseline trained again with other seeds"


def test_noise_floor_without_a_control_is_of_halves(experiment: Store, registry: Registry):
    """Of the experiment's own runs; three are too few."""
    note = only(Results(experiment.folder, registry)).number.decomposition.positive.noise.note
    assert note == "3 runs of the baseline: halves of them need at least 4"


def test_null_control_is_a_family_of_its_own(controlled: Results):
    """It must not make the claims about the rewards weaker: alone these have the same p-values."""
    asked, control = controlled.combinations
    assert asked.answer.claims == control.answer.claims
    assert asked.answer.ruling.asked == control.answer.ruling.asked == 1
    assert _corrected_apart([asked]) == pytest.approx(_corrected_of(asked))


def test_null_control_before_it_is_trained_says_so(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """As a folder of version 0.1 will for ever, which compared the baseline's runs with themselves."""
    store = Store.create(tmp_path, make_plan(make_cell(), make_cell(seed=1), control={0: 1}))
    finish(store, make_cell(), [1.0, 0.5])
    (control,) = Results(store.folder, registry).combinations
    assert control.headline.robot == "Nothing to compare: baseline is not trained again with other seeds yet."


def test_baseline_is_not_compared_with_itself_unasked(experiment: Store, registry: Registry):
    """Only where an experiment names it among its rewards."""
    assert [item.proposed for item in Results(experiment.folder, registry).combinations] == ["arp"]


# Manners


@pytest.fixture(name="acted")
def _acted(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path) -> Callable[..., Comparison]:
    """Compares two seeds of both rewards, whose evaluations in both manners are given by seed."""

    def compare(own: Sequence[bool], otherwise: Mapping[int, Sequence[bool] | None]) -> Comparison:
        cells = [make_cell(seed=seed, reward=reward) for seed in (0, 1) for reward in (BASELINE, ARP)]
        store = Store.create(tmp_path, make_plan(*cells))
        for cell in cells:
            finish(store, cell, [1.0, 0.5], own, otherwise=otherwise[cell.seed])
        combination: Comparison = only(Results(store.folder, registry))
        return combination

    return compare


def test_every_metric_is_compared_in_every_manner(acted: Callable[..., Comparison], registry: Registry):
    """The policy in both, and the training itself."""
    combination = acted([True], {0: [True], 1: [False]})
    manners = ["deterministic", "stochastic", "while training"]
    assert [
        change.measure.manner for change in combination.measured.changes if change.name == "success_rate"
    ] == manners
    assert len(combination.measured.changes) == 3 * len(registry.names("metrics"))


def test_manner_that_a_cell_lacks_is_left_out(acted: Callable[..., Comparison]):
    """Folders of version 0.1, gone on with now, have it of the new cells alone: it must not decide."""
    combination = acted([True], {0: [True, False, True], 1: None})
    assert combination.measured.episodes == {"deterministic": 1, "while training": 0}
    assert combination.manner == "deterministic"
    assert combination.decisive is not None


def test_episodes_are_those_of_the_cell_with_the_fewest(acted: Callable[..., Comparison]):
    """What rests on fewer must not be taken for more."""
    assert acted([True], {0: [True] * 3, 1: [True] * 2}).measured.episodes["stochastic"] == 2


def test_shares_know_their_episodes(acted: Callable[..., Comparison]):
    """Their intervals allow for rare failures; a distance is no share."""
    measures = {change.name: change.measure for change in acted([True] * 4, {0: None, 1: None}).measured.changes[:13]}
    assert measures["success_rate"].episodes == 4
    assert measures["final_distance"].episodes is None


# Along the budget


def _learned(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, folder: Path, *learned: dict[int, list[bool]]
) -> Comparison:
    """Two seeds of both rewards with these evaluations while learning, every 5 of 12 steps."""
    rewards = (BASELINE, ARP)
    cells = [make_cell(seed=seed, reward=reward, evaluate_every=5) for seed in range(2) for reward in rewards]
    store = Store.create(folder, make_plan(*cells))
    for cell, given in zip(cells, learned, strict=True):
        finish(store, cell, [1.0, 0.5], learned=given)
    combination: Comparison = only(Results(store.folder, registry))
    return combination


def test_success_is_compared_at_every_evaluation_before_the_end(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """What decides about the robot, of both rewards, seed by seed."""
    never, always = {5: [False], 10: [False]}, {5: [False], 10: [True]}
    combination = _learned(make_cell, make_plan, registry, tmp_path, never, always, never, always)
    assert [moment.steps for moment in combination.measured.along] == [5, 10]
    told = [(moment.changes[0].baseline, moment.changes[0].proposed) for moment in combination.measured.along]
    assert told == [(0.0, 0.0), (0.0, 1.0)]
    assert [change.name for change in combination.measured.along[0].changes] == ["success_rate", "time_to_target"]
    assert {change.measure.manner for change in combination.measured.along[1].changes} == {"after 10 steps"}


def test_evaluations_that_were_due_together_are_compared(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """An algorithm that acts for several steps at a time steps over a multiple, seed by seed elsewhere."""
    given = [{5: [True], 10: [True]}, {6: [True], 11: [True]}, {7: [True], 10: [True]}, {5: [True], 11: [True]}]
    combination = _learned(make_cell, make_plan, registry, tmp_path, *given)
    assert [moment.steps for moment in combination.measured.along] == [5, 10]


def test_evaluation_that_one_cell_lacks_is_left_out(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Seeds are compared in pairs."""
    full, short = {5: [True], 10: [True]}, {10: [True]}
    combination = _learned(make_cell, make_plan, registry, tmp_path, full, full, short, full)
    assert [moment.steps for moment in combination.measured.along] == [10]


def test_how_fast_was_learned_is_compared(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """Area under the curve of success, and steps to the goal; the last evaluation succeeds here."""
    slow, fast = {5: [False], 10: [False]}, {5: [True], 10: [True]}
    combination = _learned(make_cell, make_plan, registry, tmp_path, slow, fast, slow, fast)
    area, steps = combination.measured.changes_of("while learning")
    assert (area.baseline, area.proposed) == pytest.approx((1 / 3, 1.0))
    assert (steps.baseline, steps.proposed) == (12.0, 5.0)


def test_nothing_along_the_budget_without_evaluations(experiment: Store, registry: Registry):
    """Nor how fast was learned."""
    combination = only(Results(experiment.folder, registry))
    assert combination.measured.along == combination.measured.changes_of("while learning") == ()


# Several claims


def _claims(combination: Comparison) -> list[Any]:
    """All that have a p-value, in order."""
    splits = list(combination.number.splits.values())
    changes: list[Change] = [
        *combination.measured.changes,
        *(it for moment in combination.measured.along for it in moment.changes),
    ]
    return [claim for claim in (*splits, *changes) if claim.outcomes is not None]


def _corrected_of(*combinations: Comparison) -> list[float]:
    return [hint.corrected for combination in combinations for hint in _hints(combination)]


def _corrected_apart(combinations: Sequence[Comparison]) -> list[float]:
    return corrected_p([hint.outcomes for combination in combinations for hint in _hints(combination)])


def _hints(combination: Comparison) -> list[Any]:
    """All claims but those of the measures that the verdict rests on."""
    ruled = {id(it) for it in (*combination.decisive_changes, combination.measured.speed)}
    return [claim for claim in _claims(combination) if id(claim) not in ruled]


def test_all_claims_of_all_combinations_are_one_family(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Both etas and every measure that does not decide are corrected together; one without seeds claims nothing."""
    lonely = Choice("arp", (("k1", 1.0), ("k2", 4.0)), "arp:k2=4")
    cells = [make_cell(seed=seed, reward=reward) for seed in range(7) for reward in (BASELINE, ARP, STRONG)]
    store = Store.create(tmp_path, make_plan(*cells, make_cell(reward=lonely)))
    fail(store, make_cell(reward=lonely), "it broke")
    for cell in cells:
        good = {"baseline": False, "arp": cell.seed != 3, "arp:k2=2": True}[cell.reward.label]
        finish(store, cell, (BASELINE_RUNS if cell.reward == BASELINE else ARP_RUNS)[cell.seed % 3], [good, True])
    one, two, none = Results(store.folder, registry).combinations
    found = _corrected_of(one, two)
    assert found == _corrected_apart([one, two])
    assert found != [*_corrected_apart([one]), *_corrected_apart([two])]
    assert one.answer.claims == two.answer.claims == none.answer.claims == len(found)
    assert _claims(none) == []
    assert two.decisive.p == pytest.approx(2 * 0.5**7)  # seven that never fail beside seven that do half of the time


def test_one_seed_claims_nothing(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """There is no way to deal its labels that says something: no p-value, before or after correction."""
    cells = [make_cell(), make_cell(reward=ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, [1.0, 1.5, 0.5])
    combination = only(Results(store.folder, registry))
    assert combination.answer.claims == 0
    assert {change.corrected for change in combination.measured.changes} == {None}


def test_combinations_with_different_seeds_are_swapped_together(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """One that lacks a seed is tested on the trainings that it has."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(4) for reward in (BASELINE, ARP, STRONG)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, [1.0, 0.5], [cell.reward != BASELINE])
    fail(store, make_cell(seed=3, reward=STRONG), "no luck")
    full, short = Results(store.folder, registry).combinations
    assert (full.seeds, short.seeds) == ((0, 1, 2, 3), (0, 1, 2))
    assert [full.decisive.p, short.decisive.p] == pytest.approx([2 / math.comb(8, 4), 1 / math.comb(7, 3)])
    assert len(full.decisive.outcomes) == len(short.decisive.outcomes)


# Rewards that cannot score


def _nothing_is_split(combination: Any, reason: str) -> None:
    """Eta and behaviour stand, and each part says why it does not."""
    assert combination.number.eta_p.value is not None
    assert combination.number.eta_p.low is not None
    assert combination.decisive.baseline == 1.0
    for split in (combination.number.decomposition.negative, combination.number.decomposition.positive):
        assert not split.paths
        for part in (split.ruler, split.behaviour, split.interaction):
            assert part.value is None
            assert reason in part.note
    assert set(combination.curves) == {BB, KK}
    assert f"not split: {split.ruler.note}." in combination.headline.number
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
        finish(store, cell, BASELINE_RUNS[cell.seed])
    _nothing_is_split(only(Results(store.folder, registry)), "No reward 'lost'")


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
        finish(store, cell, BASELINE_RUNS[cell.seed], rewards=rewards)
    reason = f"reward {changed} now pays its recorded steps differently: it has changed"
    _nothing_is_split(only(Results(store.folder, registry)), reason)


def test_last_bits_are_no_change_of_a_reward(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Another machine's numbers may differ in them, and the folder is still read."""
    cells = [make_cell(reward=reward) for reward in (BASELINE, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        rewards = np.nextafter(paid(BASELINE_RUNS[0], 1.5 if cell.reward == ARP else 1.0), 10.0)
        finish(store, cell, BASELINE_RUNS[0], rewards=rewards)
    assert only(Results(store.folder, registry)).number.decomposition.positive.ruler.value is not None


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
        ("raise ZeroDivisionError('by\\nnothing')", " could not score the runs: ZeroDivisionError: by nothing"),
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
        finish(store, cell, [*runs[cell.seed][:3], 0.5, 0.0], rewards=own and [*own[:3], -0.5, 0.0])
    results = Results(store.folder, registry)
    combination = only(results)
    assert combination.number.eta_n.value is not None
    assert reason in combination.number.decomposition.negative.ruler.note
    assert json.dumps(results.to_json(), allow_nan=False)
