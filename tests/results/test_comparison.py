"""One proposed reward against the baseline."""

import json
from dataclasses import replace

import pytest

from harness.eta import Answer, Ruling
from harness.files.plain import to_plain
from harness.record.cell import BROUGHT
from harness.registry import Choice
from harness.results import Group
from harness.results.compare import with_verdicts
from harness.results.comparison import StepChange
from tests.results.told import SUCCESS, change, comparison, rates

WORSE = change(SUCCESS._replace(manner="stochastic"), rates(0.5, 0.25), range(20))


@pytest.fixture(name="combination")
def _combination():
    """Policies that get better acting one way, which decides, and worse the other."""
    found = comparison("arp", {"success_rate": rates(0.5, 0.75)})
    return replace(found, measured=replace(found.measured, changes=(WORSE, *found.measured.changes)))


def measured(combination, **fields):
    """Where something else was measured."""
    return replace(combination, measured=replace(combination.measured, **fields))


def test_cells_that_differ_are_in_other_groups(make_cell, subtests):
    """Whatever decides a result, reward and seed apart, which are what is compared."""
    assert Group.of(make_cell()) == Group.of(make_cell(seed=7, reward=Choice("arp")))
    for field in ["simulator", "robot", "task", "algorithm", "steps", "evaluation_episodes", "evaluate_every"]:
        with subtests.test(field=field):
            other = Choice("other") if isinstance(getattr(make_cell(), field), Choice) else 99
            assert Group.of(make_cell()) != Group.of(make_cell(**{field: other}))


def test_manners_of_evaluation_are_not_mixed(make_cell):
    """Policies that drew their actions are not compared with some that did not, and the group says which."""
    groups = [Group.of(make_cell(deterministic=given)) for given in (True, False)]
    told = [(group.manner, to_plain(group)["deterministic"]) for group in groups]
    assert told == [("deterministically", True), ("stochastically", False)]


def test_rewards_are_what_is_compared_in_a_combination(make_cell):
    """So its group has a simulator and no reward; that of policies from several simulators has it the other way."""
    cell = make_cell()
    group, policies = Group.of(cell), Group.of(cell, compared="simulator")
    assert (group.simulator, group.reward) == (cell.simulator, None)
    assert (policies.simulator, policies.reward) == (None, cell.reward)
    assert policies == Group.of(make_cell(simulator=Choice("other")), compared="simulator")


def test_title_names_all_that_is_shared(combination):
    """In one line, what is compared left out; JSON has the same names by kind."""
    group = combination.group
    assert group.title == "mujoco · sac · fd100 · reach"
    assert group._replace(simulator=None, reward=Choice("arp", (), "arp")).title == "sac · arp · fd100 · reach"
    assert list(to_plain(group)) == ["simulator", "algorithm", "robot", "task", "steps", "deterministic"]


def test_the_discount_is_told_to_people_alone(combination):
    """In an environment: what programs read keeps the label."""
    learner = Choice("ppo", (("gamma", 0.8),), "ppo")
    group = combination.group._replace(simulator=BROUGHT.simulator, algorithm=learner)
    assert group.title == "ppo:gamma=0.8 · fd100 · reach"
    assert to_plain(group)["algorithm"] == group.labels["algorithm"] == "ppo"
    assert combination.group._replace(algorithm=learner).title.startswith("mujoco · ppo · ")


@pytest.mark.parametrize(
    ("deterministic", "episodes", "manner"),
    [
        (True, {"deterministic": 20, "stochastic": 20, "while training": 900}, "deterministic"),
        (False, {"stochastic": 20, "deterministic": 20, "while training": 900}, "stochastic"),
        (True, {"deterministic": 1, "stochastic": 20, "while training": 900}, "stochastic"),
        (False, {"stochastic": 20, "deterministic": 1}, "stochastic"),
        (True, {"deterministic": 20}, "deterministic"),
        (True, {}, "deterministic"),
    ],
)
def test_manner_with_the_most_episodes_decides(combination, deterministic, episodes, manner):
    """Of equally many the cells' own; a training, which explores, never does."""
    group = combination.group._replace(deterministic=deterministic)
    assert replace(measured(combination, episodes=episodes), group=group).manner == manner


@pytest.mark.parametrize(("drawn", "answer"), [(1, Answer.HELPS), (200, Answer.HURTS)])
def test_deciding_manner_gives_the_answer(combination, drawn, answer):
    """The policies get better acting one way and worse the other."""
    (found,) = with_verdicts([measured(combination, episodes={"deterministic": 100, "stochastic": drawn})])
    assert found.decisive.measure.manner == found.manner
    assert found.headline.answer is answer


def test_an_evaluation_on_the_way_is_a_hint(combination):
    """Better or worse by its corrected p, and no answer."""
    same = replace(WORSE, proposed=WORSE.baseline, corrected=1.0)
    none, worse = (StepChange(5, (it,)) for it in (same, replace(WORSE, corrected=WORSE.p, low=-0.4, high=-0.1)))
    assert (none.answer, worse.answer) == ("cannot tell", "worse")
    (told,) = measured(combination, along=(worse,)).to_json()["along_the_budget"]
    assert (told["steps"], told["answer"], [it["name"] for it in told["behaviour"]]) == (5, "worse", ["success_rate"])


def test_null_control_names_its_sides_apart(combination):
    """Both are the baseline."""
    control = replace(combination, proposed="baseline")
    assert control.is_control
    assert "% with baseline (other seeds), " in control.headline.robot
    assert "% with baseline; " in control.headline.robot


def test_questions_decide_how_many_seeds_it_takes():
    """More questions asked together, more seeds at most."""
    unsure = comparison("arp", {"success_rate": rates(0.5, 0.55)})
    few, many = (
        replace(unsure, answer=replace(unsure.answer, ruling=Ruling(asked=asked))).headline.seeds_to_decide
        for asked in (1, 100)
    )
    assert few < many


def test_json_is_plain(combination):
    """Without NaN and without curves."""
    told = json.loads(json.dumps(combination.to_json(), allow_nan=False))
    assert [change["manner"] for change in told["behaviour"]] == ["stochastic", "deterministic"]
    headline = combination.headline
    assert told["headline"] == {**headline.to_json(), "pay": combination.pay_sentence}
    assert told["episodes"] == {"deterministic": 100}


def test_repr_is_a_line(combination):
    """What was compared, where, in how many seeds, and the answer; a comparison holds curves of every step."""
    assert repr(combination) == (
        "<Comparison in mujoco · sac · fd100 · reach: arp against baseline, 20 seeds: cannot tell>"
    )


def test_notebook_gets_the_answer(combination):
    """In words, escaped."""
    told = replace(combination, proposed="<b>")._repr_html_()
    assert told.count("<p>") == 3
    assert "&lt;b&gt;" in told
    assert "<b>" not in told
