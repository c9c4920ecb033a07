"""One proposed reward against the baseline."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from harness.eta.behaviour_change import Change, Quantity, change_of
from harness.eta.curve import curve_of
from harness.eta.decomposition import decompose
from harness.eta.headline import Answer
from harness.eta.index import Ratio
from harness.eta.scored_sums import BB, BK, KB, KK
from harness.eta.swaps import swaps_of
from harness.eta.verdict.ruling import Ruling
from harness.record.cell import BROUGHT
from harness.registry.choice import Choice
from harness.results.comparison import Behaviour, Comparison, Group, Judged, Number, StepChange
from harness.results.verdicts import with_verdicts
from tests.results.told import comparison, rates

GROUP = Group(
    "fd100", Choice("fd100-reach", (), "fd100-reach"), Choice("wander", (), "wander"), steps=12, evaluation_episodes=20,
    simulator=Choice("ideal", (), "ideal"),
)  # fmt: skip
CURVES = {pair: curve_of([np.array([-1.0, 3.0 * factor])] * 6) for pair, factor in ((BB, 1), (BK, 1), (KB, 2), (KK, 2))}
SWAPS = swaps_of(range(6))


def change(name: str, manner: str, proposed: float) -> Change:
    """Of six seeds, from 0.5 under the baseline."""
    one, other = ({seed: value + 0.001 * seed for seed in range(6)} for value in (0.5, proposed))
    found = change_of(Quantity(name, "", "higher", manner, 20), one, other, SWAPS, [0.0] * 12)
    return replace(found, corrected=found.p)


CHANGES = (
    change("closest_distance", "deterministic", 0.5),
    change("success_rate", "deterministic", 0.75),
    change("success_rate", "stochastic", 0.25),
)


SEEDS = tuple(range(6))


@pytest.fixture(name="combination")
def _combination():
    return Comparison(
        GROUP,
        "baseline",
        "arp",
        SEEDS,
        (SEEDS, SEEDS),
        Behaviour(CHANGES, episodes={"deterministic": 20}),
        Number(decompose(CURVES)),
        Judged(claims=5),
        CURVES,
    )


@pytest.fixture(name="empty")
def _empty():
    return Comparison(GROUP, "baseline", "arp", (), number=Number(why_none="no training with baseline is done"))


def test_cells_that_differ_are_in_other_groups(make_cell, subtests):
    """Whatever decides a result, reward and seed apart."""
    for field in ["simulator", "robot", "task", "algorithm", "steps", "evaluation_episodes", "evaluate_every"]:
        with subtests.test(field=field):
            other: Any = Choice("other") if isinstance(getattr(make_cell(), field), Choice) else 99
            assert Group.of(make_cell()) != Group.of(make_cell(**{field: other}))


def test_manners_of_evaluation_are_not_mixed(make_cell):
    """Policies that drew their actions are not compared with some that did not, and the group says which."""
    groups = [Group.of(make_cell(deterministic=given)) for given in (True, False)]
    assert [group.manner for group in groups] == ["deterministically", "stochastically"]
    assert [group.to_json()["deterministic"] for group in groups] == [True, False]


def test_rewards_and_seeds_share_a_group(make_cell):
    """They are what is compared."""
    assert Group.of(make_cell()) == Group.of(make_cell(seed=7, reward=Choice("arp")))


def test_rewards_are_what_is_compared_in_a_combination(make_cell):
    """So its group has a simulator and no reward; that of policies from several simulators has it the other way."""
    cell = make_cell()
    group, policies = Group.of(cell), Group.of(cell, compared="simulator")
    assert (group.simulator, group.reward) == (cell.simulator, None)
    assert (policies.simulator, policies.reward) == (None, cell.reward)
    assert policies == Group.of(make_cell(simulator=Choice("other")), compared="simulator")


def test_title_names_all_that_is_shared():
    """In one line, what is compared left out; JSON has the same names by kind."""
    assert GROUP.title == "ideal · wander · fd100 · fd100-reach"
    policies = GROUP._replace(simulator=None, reward=Choice("arp", (), "arp"))
    assert policies.title == "wander · arp · fd100 · fd100-reach"
    assert list(GROUP.to_json()) == ["simulator", "algorithm", "robot", "task", "steps", "deterministic"]


def test_runs_are_split_where_both_were_scored(combination, empty):
    """By the other's reward; without it, or without a seed, they are not."""
    alone = decompose({pair: CURVES[pair] for pair in (BB, KK)})
    assert combination.number.is_split
    assert not replace(combination, number=replace(combination.number, decomposition=alone)).number.is_split
    assert not empty.number.is_split


def test_etas_and_indices_are_the_decompositions(combination):
    """They are at hand without it."""
    found = combination.number.decomposition
    assert (combination.number.eta_n, combination.number.eta_p) == (found.eta_n, found.eta_p)
    assert combination.to_json()["baseline_index"] == found.baseline.to_json()
    assert combination.to_json()["proposed_index"] == found.proposed.to_json()


def test_success_is_found_among_the_changes(combination, empty):
    """By its name, in the manner that decides; there may be none."""
    assert combination.decisive is CHANGES[1]
    assert empty.decisive is None


def test_manner_with_the_most_episodes_decides(combination, subtests):
    """Of equally many the cells' own; a training, which explores, never does."""
    rows = [
        (True, {"deterministic": 20, "stochastic": 20, "while training": 900}, "deterministic"),
        (False, {"stochastic": 20, "deterministic": 20, "while training": 900}, "stochastic"),
        (True, {"deterministic": 1, "stochastic": 20, "while training": 900}, "stochastic"),
        (False, {"stochastic": 20, "deterministic": 1}, "stochastic"),
        (True, {"deterministic": 20}, "deterministic"),
        (True, {}, "deterministic"),
    ]
    for deterministic, episodes, manner in rows:
        with subtests.test(deterministic=deterministic, episodes=episodes, manner=manner):
            group = GROUP._replace(deterministic=deterministic)
            assert (
                replace(combination, group=group, measured=replace(combination.measured, episodes=episodes)).manner
                == manner
            )


def test_deciding_manner_gives_the_answer(combination):
    """The policies get better acting one way and worse the other."""
    assert ruled(combination).headline.answer is Answer.HELPS
    drawn = replace(
        combination, measured=replace(combination.measured, episodes={"deterministic": 1, "stochastic": 20})
    )
    assert ruled(drawn).headline.answer is Answer.HURTS


def ruled(comparison: Comparison) -> Comparison:
    """With the verdict of an experiment that asks nothing else."""
    (found,) = with_verdicts([comparison])
    return found


def test_an_evaluation_on_the_way_is_a_hint(combination):
    """Better or worse by its corrected p, and no answer."""
    none, worse = (StepChange(5, (change("success_rate", "after 5 steps", value),)) for value in (0.5, 0.25))
    assert none.answer == "cannot tell"
    assert worse.answer == "worse"
    (told,) = replace(combination, measured=replace(combination.measured, along=(worse,))).to_json()["along_the_budget"]
    assert (told["steps"], told["answer"], [it["name"] for it in told["behaviour"]]) == (5, "worse", ["success_rate"])


def test_null_control_names_its_sides_apart(combination):
    """Both are the baseline."""
    control = replace(combination, proposed="baseline")
    assert control.is_control
    assert "75.2% with baseline (other seeds), 50.2% with baseline; " in control.headline.robot


def test_questions_decide_how_many_seeds_it_takes(combination):
    """More questions asked together, more seeds at most."""
    unsure = replace(
        combination, measured=replace(combination.measured, changes=(change("success_rate", "deterministic", 0.5),))
    )
    few, many = (
        replace(unsure, answer=replace(unsure.answer, ruling=Ruling(asked=asked))).headline.seeds_to_decide
        for asked in (1, 100)
    )
    assert few[0] == many[0]
    assert few[1] < many[1]


def test_outcomes_are_those_of_every_claim(combination, empty):
    """Both etas first, then measures, then those along the budget."""
    moment = StepChange(5, (change("success_rate", "after 5 steps", 0.5),))
    found = replace(combination, measured=replace(combination.measured, along=(moment,))).outcomes
    split, expected = combination.number.decomposition, [it.outcomes for it in (*CHANGES, *moment.changes)]
    assert [id(it) for it in found] == [id(it) for it in (split.negative.outcomes, split.positive.outcomes, *expected)]
    assert empty.outcomes == []


def test_without_a_seed_the_reason_stands_everywhere(empty):
    """In both ratios, in the answer, and nowhere a number."""
    reason = "no training with baseline is done"
    assert empty.number.eta_n == empty.number.eta_p == Ratio(None, notes=(reason,))
    assert empty.number.decomposition is None
    assert (empty.headline.answer, empty.headline.number) == (Answer.CANNOT_TELL, "")
    assert empty.headline.robot == f"Nothing to compare: {reason}."


def test_json_is_plain_and_the_same_with_and_without_seeds(combination, empty):
    """The same keys in the same order, without NaN and without curves."""
    full, nothing = (json.loads(json.dumps(one.to_json(), allow_nan=False)) for one in (combination, empty))
    assert list(full) == list(nothing)
    assert [change["name"] for change in full["behaviour"]] == ["closest_distance", "success_rate", "success_rate"]
    told = combination.headline
    assert full["headline"] == {**told.to_json(), "robot": told.robot, "pay": combination.pay_sentence}
    assert (full["claims"], full["episodes"]) == (5, {"deterministic": 20})


def test_repr_is_a_line(combination, empty):
    """What was compared, where, in how many seeds, and the answer; a comparison holds curves of every step."""
    assert repr(combination) == (
        "<Comparison in ideal · wander · fd100 · fd100-reach: arp against baseline, 6 seeds: cannot tell>"
    )
    assert "0 seeds" in repr(empty)


def test_notebook_gets_both_answers(combination):
    """In words, escaped."""
    told = replace(combination, proposed="<b>")._repr_html_()
    assert told.count("<p>") == 3
    assert "&lt;b&gt;" in told
    assert "<b>" not in told


def test_the_smallest_p_is_that_of_both_numbers_of_trainings():
    """No p of the verdict is below it: four against three have one way in 35."""
    few = comparison("dense", {"success_rate": rates(0.5, 0.9, 4)})
    assert replace(few, trained=((0, 1, 2, 3), (0, 1, 2))).to_json()["smallest_p"] == pytest.approx(1 / 35)


def test_the_discount_is_told_to_people_alone():
    """In an environment: what programs read keeps the label."""
    group = GROUP._replace(simulator=BROUGHT.simulator, algorithm=Choice("ppo", (("gamma", 0.8),), "ppo"))
    assert group.title == "ppo:gamma=0.8 · fd100 · fd100-reach"
    assert group.to_json()["algorithm"] == group.labels["algorithm"] == "ppo"
    assert GROUP._replace(algorithm=group.algorithm).title.startswith("ideal · ppo · ")
