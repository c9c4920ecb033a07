"""From an experiment's records to its comparisons, from folders made by hand."""

import json
import math
from importlib.metadata import entry_points

import numpy as np
import pytest

from harness import load_registry, load_results
from harness.eta import corrected_p, curve_of
from harness.record import EpisodeFacts
from harness.registry import Choice
from tests.results.folders import ARP, ARP_RUNS, BASELINE, BASELINE_RUNS, fail, load_without, only, paid

STRONG = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")


def _index(runs, k2=1.0, seeds=(0, 1, 2)):
    """Of these runs under `arp`, or under `baseline`."""
    return curve_of([np.array(paid(runs[seed], k2)) for seed in seeds]).index


def test_indices_are_of_the_recorded_rewards(experiment):
    """Accumulated, cut to the group's shortest run, averaged; the ratios are of these, not rounded."""
    number = only(experiment).number
    baseline, proposed = _index(BASELINE_RUNS), _index(ARP_RUNS, 1.5)
    assert (number.decomposition.baseline, number.decomposition.proposed) == (baseline, proposed)
    assert (baseline.steps, proposed.steps) == (7, 5)
    assert number.eta_n.value == proposed.negative_sum / baseline.negative_sum


def test_runs_are_scored_under_the_other_reward(experiment):
    """Ruler and behaviour are those of the four scored groups, on both paths."""
    runs = [(BASELINE_RUNS, 1.0), (ARP_RUNS, 1.0), (BASELINE_RUNS, 1.5), (ARP_RUNS, 1.5)]
    bb, bk, kb, kk = (_index(*it).positive_sum for it in runs)
    paths = only(experiment).number.decomposition.positive.paths
    assert [(it.ruler.value, it.behaviour.value) for it in paths] == [(kk / bk, bk / bb), (kb / bb, kk / kb)]


def test_behaviour_is_the_mean_over_seeds(both, made):
    """Of the trained policies under each reward, and of random actions under both; no reward enters."""
    left = [
        {"trained": [True, False, False, False]},
        {"trained": [True, True]},
        {"trained": [True, True, True, False]},
        {"trained": [True, True], "floor": [True, False, False, False]},
    ]
    combination = only(made(both(2), lambda cell: left[2 * cell.seed + (cell.reward == ARP)]))
    by_name = {change.name: change for change in combination.measured.changes_of("deterministic")}
    success = by_name["success_rate"]
    assert (success.baseline, success.proposed, success.random) == (0.5, 1.0, 0.0625)
    assert by_name["final_distance"].proposed == pytest.approx(0.01)


@pytest.mark.parametrize("period", [0.05, None])
def test_an_arm_helps_by_time_where_its_limit_is_known(both, made, period):
    """Both rewards always reach the target, one of them sooner. A failure would count as the whole horizon."""
    facts = EpisodeFacts(horizon=100, control_period=period)

    def left(cell):
        return {"trained": [True] * 5, "took": 20 + cell.seed % 4 + 60 * (cell.reward == BASELINE), "facts": facts}

    found = only(made(both(8), left))
    ends = {it.name: it.measure.ends for it in found.measured.changes_of("deterministic")}
    certain = {name: of for name, of in ends.items() if np.isfinite(of).all()}
    shares = dict.fromkeys(["success_rate", "ground_hits", "obstacle_hits", "spl", "timeouts"], (0.0, 1.0))
    assert certain == {**shares, "steps_to_target": (1.0, 100.0), **({"time_to_target": (0.0, 5.0)} if period else {})}
    assert found.headline.answer == ("helps" if period else "cannot tell")
    assert found.headline.decided_by == ("time_to_target" if period else None)


def test_seed_that_is_done_under_one_reward_is_left_out(experiment, make_cell):
    """Seeds are compared in pairs: the baseline's third run does not count while the proposed one failed."""
    fail(experiment.store, make_cell(seed=2, reward=ARP), "no luck")
    assert only(load_results(experiment.folder)).headline.answer == "interim"
    combination = only(load_without(experiment.store, make_cell(seed=2, reward=ARP)))
    assert combination.seeds == (0, 1)
    assert combination.number.decomposition.baseline == _index(BASELINE_RUNS, seeds=(0, 1))
    assert {curve.count for curve in combination.curves.values()} == {2}
    assert combination.decisive.seeds == 2


def test_rows_of_both_groups_have_the_same_seed(experiment):
    """Whatever the order in which the cells ended, row i of both groups is of the i-th seed."""
    combination = only(experiment)
    assert combination.seeds == (0, 1, 2)
    for (scoring, trained), curve in combination.curves.items():
        runs = BASELINE_RUNS if trained == "baseline" else ARP_RUNS
        steps, k2 = min(map(len, runs.values())), 1.0 if scoring == "baseline" else 1.5
        np.testing.assert_array_equal(curve.runs, [np.cumsum(paid(runs[seed], k2))[:steps] for seed in (0, 1, 2)])
    assert len(combination.curves) == 4


def test_combination_without_a_training_of_one_reward_says_so(both, made):
    """It is listed, without numbers, and the note has the reason."""
    results = made(both(1), lambda cell: None if cell.reward == ARP else {})
    (combination,) = results.to_json()["combinations"]
    reason = "no training with arp is done"
    nothing = {"value": None, "low": None, "high": None, "seeds": 0, "note": reason}
    assert combination["eta_N"]["eta"] == combination["eta_P"]["behaviour"] == nothing
    assert (combination["baseline_index"], combination["proposed_index"], combination["seeds"]) == (None, None, [])
    assert (combination["behaviour"], combination["total"]) == ([], None)
    headline = combination["headline"]
    assert (headline["answer"], headline["behaviour"]) == ("interim", f"Nothing to compare: {reason}.")
    assert only(results).curves == {}


def test_skipped_combination_is_not_compared(both, made):
    """What cannot work is among the cells, and makes no empty row in the table."""
    skipped = tuple((cell, "no") for cell in both(1, algorithm=Choice("buttons", (), "buttons")))
    found = made(both(1), lambda cell: None, skipped=skipped).combinations
    assert [item.group.algorithm.label for item in found] == ["wander"]


def test_every_proposal_of_every_group_is_compared(both, made):
    """Groups differ in simulator, robot, task, algorithm or steps; their runs are never mixed."""
    cells = [cell for steps in (12, 24) for cell in both(1, (BASELINE, ARP, STRONG), steps=steps)]
    found = made(cells, lambda cell: {"distances": [1.0, 2.0 + cells.index(cell)]}).combinations  # I_N is -1 - index
    assert [(item.group.steps, item.proposed, item.number.eta_n.value) for item in found] == [
        (12, "arp", 2.0),
        (12, "arp:k2=2", 3.0),
        (24, "arp", 5 / 4),
        (24, "arp:k2=2", 6 / 4),
    ]


# The null control


@pytest.fixture(name="controlled")
def _controlled(both, make_cell, made):
    """Seeds 0 to 5 of both rewards, and the baseline again with 6 to 11."""

    def how(cell):
        is_arp = cell.reward == ARP
        runs = ARP_RUNS if is_arp else BASELINE_RUNS
        return {"distances": runs[cell.seed % 3], "trained": [True, is_arp], "learned": {5: [True]}}

    again = [make_cell(seed=seed) for seed in range(6, 12)]
    return made([*both(6), *again], how, control={seed: seed + 6 for seed in range(6)})


def test_null_control_compares_a_seed_with_another_one(controlled):
    """Both groups are the baseline's, and none of their runs is the same; it comes last, and is no other's noise."""
    asked, control = controlled.combinations
    assert (asked.is_control, control.is_control) == (False, True)
    assert (control.baseline, control.proposed) == ("baseline", "baseline")
    assert asked.seeds == control.seeds == (0, 1, 2, 3, 4, 5)
    # Seeds 6 to 11 repeat the runs of 0 to 5 here: as good a training gives 1 everywhere.
    assert [control.number.splits[name].eta.value for name in ("eta_N", "eta_P")] == [1.0, 1.0]
    assert asked.number.decomposition.positive.noise.note == "the baseline trained again with other seeds"


def test_null_control_is_a_family_of_its_own(controlled):
    """It must not make the claims about the rewards weaker: alone these have the same p-values."""
    asked, control = controlled.combinations
    assert asked.answer.claims == control.answer.claims
    assert asked.answer.ruling.asked == control.answer.ruling.asked == 1
    assert _corrected_apart(asked) == pytest.approx([hint.corrected for hint in _hints(asked)])


def test_null_control_before_it_is_trained_says_so(make_cell, made):
    """As a folder of version 0.1 will for ever, which compared the baseline's runs with themselves."""
    cells = [make_cell(), make_cell(seed=1)]
    (control,) = made(cells, lambda cell: None if cell.seed else {}, control={0: 1}).combinations
    assert control.headline.robot == "Nothing to compare: baseline is not trained again with other seeds yet."


# Manners


@pytest.fixture(name="acted")
def _acted(both, made):
    """Compares two seeds of both rewards, whose evaluations in both manners are given by seed."""
    return lambda own, *otherwise: only(made(both(2), lambda cell: {"trained": own, "otherwise": otherwise[cell.seed]}))


def test_every_metric_is_compared_in_every_manner(acted, registry):
    """The policy in both, and the training itself."""
    changes = acted([True], [True], [False]).measured.changes
    manners = ["deterministic", "stochastic", "while training"]
    assert [it.measure.manner for it in changes if it.name == "success_rate"] == manners
    assert len(changes) == 3 * len(registry.names("metrics"))


def test_manner_that_a_cell_lacks_is_left_out(acted):
    """Folders of version 0.1, gone on with now, have it of the new cells alone: it must not decide."""
    combination = acted([True], [True, False, True], None)
    assert combination.measured.episodes == {"deterministic": 1, "while training": 0}
    assert combination.manner == "deterministic"
    assert combination.decisive is not None


def test_episodes_are_those_of_the_cell_with_the_fewest(acted):
    """What rests on fewer must not be taken for more."""
    assert acted([True], [True] * 3, [True] * 2).measured.episodes["stochastic"] == 2


def test_shares_know_their_episodes(acted):
    """Their intervals allow for rare failures; a distance is no share."""
    measures = {it.name: it.measure for it in acted([True] * 4, None, None).measured.changes_of("deterministic")}
    assert [measures[name].episodes for name in ("success_rate", "final_distance")] == [4, None]


# Along the budget


@pytest.fixture(name="learned")
def _learned(both, made):
    """Compares two seeds of both rewards by what they measured; evaluations while learning, every 5 of 12 steps."""
    return lambda *of: (
        only(
            made(both(2, evaluate_every=5), lambda cell: {"learned": of[2 * cell.seed + (cell.reward == ARP)]})
        ).measured
    )


def test_success_is_compared_at_every_evaluation_before_the_end(learned):
    """What decides about the robot, of both rewards, seed by seed."""
    along = learned(*[{5: [False], 10: [False]}, {5: [False], 10: [True]}] * 2).along
    told = [(moment.steps, moment.changes[0].baseline, moment.changes[0].proposed) for moment in along]
    assert told == [(5, 0.0, 0.0), (10, 0.0, 1.0)]
    assert [change.name for change in along[0].changes] == ["success_rate", "time_to_target"]
    assert {change.measure.manner for change in along[1].changes} == {"after 10 steps"}


FULL = {5: [True], 10: [True]}


@pytest.mark.parametrize(
    ("of", "steps"),
    [
        ([FULL, {6: [True], 11: [True]}, {7: [True], 10: [True]}, {5: [True], 11: [True]}], [5, 10]),
        ([FULL, FULL, {10: [True]}, FULL], [10]),
    ],
    ids=["stepped over a multiple", "one cell lacks one"],
)
def test_evaluations_that_were_due_together_are_compared(learned, of, steps):
    """An algorithm may act for several steps at a time; seeds are compared in pairs."""
    assert [moment.steps for moment in learned(*of).along] == steps


def test_how_fast_was_learned_is_compared(learned):
    """Area under the curve of success, and steps to the goal; the last evaluation succeeds here."""
    area, steps = learned(*[{5: [False], 10: [False]}, FULL] * 2).changes_of("while learning")
    assert (area.baseline, area.proposed) == pytest.approx((1 / 3, 1.0))
    assert (steps.baseline, steps.proposed) == (12.0, 5.0)


# Several claims


def _claims(combination):
    """All that have a p-value, in order."""
    along = (it for moment in combination.measured.along for it in moment.changes)
    every = (*combination.number.splits.values(), *combination.measured.changes, *along)
    return [claim for claim in every if claim.outcomes is not None]


def _hints(*combinations):
    """All claims but those of the measures that the verdict rests on."""
    ruled = {id(it) for one in combinations for it in (*one.decisive_changes, one.measured.speed)}
    return [claim for one in combinations for claim in _claims(one) if id(claim) not in ruled]


def _corrected_apart(*combinations):
    return corrected_p([hint.outcomes for hint in _hints(*combinations)])


def test_all_claims_of_all_combinations_are_one_family(both, make_cell, made):
    """Both etas and every measure that does not decide are corrected together."""
    lonely = make_cell(reward=Choice("arp", (("k1", 1.0), ("k2", 4.0)), "arp:k2=4"))

    def how(cell):
        good = {"baseline": False, "arp": cell.seed != 3, "arp:k2=2": True}.get(cell.reward.label)
        runs = BASELINE_RUNS if cell.reward == BASELINE else ARP_RUNS
        return None if good is None else {"distances": runs[cell.seed % 3], "trained": [good, True]}

    results = made([*both(7, (BASELINE, ARP, STRONG)), lonely], how)
    fail(results.store, lonely, "it broke")
    one, two = load_without(results.store, lonely).combinations
    found = [hint.corrected for hint in _hints(one, two)]
    assert found == _corrected_apart(one, two)
    assert found != [*_corrected_apart(one), *_corrected_apart(two)]
    assert one.answer.claims == two.answer.claims == len(found)
    assert two.decisive.p == pytest.approx(2 / math.comb(14, 7))  # the likeliest two of all ways to deal labels


def test_combinations_with_different_seeds_are_swapped_together(both, made):
    """One that lacks a seed is tested on the trainings that it has."""
    results = made(both(4, (BASELINE, ARP, STRONG)), lambda cell: {"trained": [cell.reward != BASELINE]})
    fail(results.store, results.plan.cells[-1], "no luck")
    full, short = load_without(results.store, results.plan.cells[-1]).combinations
    assert (full.seeds, short.seeds) == ((0, 1, 2, 3), (0, 1, 2))
    assert [full.decisive.p, short.decisive.p] == pytest.approx([2 / math.comb(8, 4), 1 / math.comb(7, 3)])
    assert len(full.decisive.outcomes) == len(short.decisive.outcomes)


# Rewards that cannot score


LOST = Choice("lost", (), "lost")


@pytest.mark.parametrize(
    ("rewards", "changed", "reason"),
    [
        ((LOST, ARP), "", "No reward 'lost'"),
        ((BASELINE, LOST), "", "No reward 'lost'"),
        ((BASELINE, ARP), "baseline", "reward baseline now pays its recorded steps differently: it has changed"),
        ((BASELINE, ARP), "arp", "reward arp now pays its recorded steps differently: it has changed"),
    ],
)
def test_reward_that_is_gone_or_has_changed_costs_the_split_alone(both, made, rewards, changed, reason):
    """What it paid is recorded: eta and behaviour stand, and each part says why it does not."""

    def how(cell):
        rewards = np.array(paid(BASELINE_RUNS[cell.seed], 1.5 if cell.reward == ARP else 1.0))
        rewards[1] *= 1.001 if cell.reward.label == changed else 1.0
        return {"distances": BASELINE_RUNS[cell.seed], "rewards": rewards}

    combination = only(made(both(3, rewards), how, baseline=rewards[0].label))
    assert combination.number.eta_p.value is not None
    assert combination.number.eta_p.low is not None
    assert combination.decisive.baseline == 1.0
    for split in (combination.number.decomposition.negative, combination.number.decomposition.positive):
        assert not split.paths
        for part in (split.ruler, split.behaviour, split.interaction):
            assert part.value is None
            assert reason in part.note
    assert {*combination.curves} == {("baseline", "baseline"), ("proposed", "proposed")}
    assert f"not split: {split.ruler.note}." in combination.headline.number
    assert json.dumps(combination.to_json(), allow_nan=False)


def test_last_bits_are_no_change_of_a_reward(both, made):
    """Another machine's numbers may differ in them, and the folder is still read."""

    def how(cell):
        rewards = np.nextafter(paid(BASELINE_RUNS[0], 1.5 if cell.reward == ARP else 1.0), 10.0)
        return {"distances": BASELINE_RUNS[0], "rewards": rewards}

    assert only(made(both(1), how)).number.decomposition.positive.ruler.value is not None


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
        ("return carry, np.full_like(sample.distance, np.nan)", "reward broken pays a number that is not finite, or"),
        ("return carry, np.full_like(sample.distance, -1e151)", "or beyond 1e+150, on these runs"),
    ],
)
def test_reward_that_fails_on_other_runs(both, made, write_plugin, wrong, reason):
    """A plugin may do anything with motion that it never paid for: that costs the split alone."""
    plugins = load_registry([*entry_points(group="harness"), write_plugin(BROKEN.replace("DO", wrong), "broken")])

    def how(cell):
        own = cell.reward != BASELINE
        distances = [*(ARP_RUNS if own else BASELINE_RUNS)[cell.seed][:3], 0.5, 0.0]
        return {"distances": distances, "rewards": [0.0, *(-it for it in distances[1:])] if own else None}

    results = made(both(3, (BASELINE, Choice("broken", (), "broken"))), how, plugins=plugins)
    combination = only(results)
    assert combination.number.eta_n.value is not None
    assert reason in combination.number.decomposition.negative.ruler.note
    assert json.dumps(results.to_json(), allow_nan=False)
