"""The page of four engines says what its records hold: parity, rankings, and a budget that tells rewards apart."""

import json
from collections import Counter

import pytest

from tests.project import ROOT, page_of
from tests.test_reference import three

FOLDER = ROOT / "results" / "reference" / "engines"
PAGE = page_of("studies/engines")
RECORDS = {path.parent.name: json.loads(path.read_text()) for path in sorted(FOLDER.glob("*/results.json"))}
PARITY = json.loads((FOLDER / "parity.json").read_text())
SERVO = ":drive=servo"
ENGINES = {"mujoco": "MuJoCo", "pybullet": "Bullet", "drake": "Drake", "physx": "PhysX"}
DRIVES = {"": "", SERVO: ", servo"}
TRANSFER = json.loads((FOLDER / "transfer.json").read_text())
PROSE = " ".join(PAGE.split())
REWARDS = ("arp", "dense")
EACH = pytest.mark.parametrize("name", RECORDS)
EACH_REWARD = pytest.mark.parametrize("reward", REWARDS)


def ranking(name):
    """What a record says of orders."""
    (task,) = RECORDS[name]["ranking"]["tasks"]
    return task


def combinations(name, reward):
    """Of a reward, one for each simulator."""
    return [it for it in RECORDS[name]["combinations"] if it["proposed"] == reward]


def share(value):
    """As the page writes it."""
    return f"{100 * value:.1f}%"


def answers(name):
    """To the questions whether a reward that was chosen in one simulator costs success in another."""
    ways = ("chosen_in_one_used_in_other", "chosen_in_other_used_in_one")
    return Counter(pair[way]["answer"] for pair in ranking(name)["pairs"] for way in ways)


def between(measure, unit=" points", scale=100.0, digits=1):
    """The interval that a plain word rests on, as the page writes it."""
    return f"{scale * measure['low']:+.{digits}f} to {scale * measure['high']:+.{digits}f}{unit}"


def decider_of(pool):
    """The measure over all simulators that decided."""
    by = pool["decided_by"]
    success, _, learning = pool["measures"]
    return learning if by.endswith("while training") else success


def kinds(name, reward):
    """How often each answer about the robot stands in single simulators, the most frequent one first."""
    told = Counter(it["headline"]["answer"] for it in combinations(name, reward))
    plain = {
        it["headline"]["answer"]: f" ({between_times(it)})" for it in decided() if it in combinations(name, reward)
    }
    return ", ".join(f"{count} {answer.upper()}{plain.get(answer, '')}" for answer, count in told.most_common())


def decided():
    """The rows of which a plain word is said by itself."""
    told = [it for name in RECORDS for reward in REWARDS for it in combinations(name, reward)]
    return [it for it in told if it["test"]["is_decided"]]


def change_of(told, name):
    """A measure of the trained policies."""
    return next(it for it in told["behaviour"] if (it["name"], it["manner"]) == (name, "deterministic"))


def between_times(told):
    """The interval of the time to the target, in seconds."""
    return between(change_of(told, "time_to_target"), " s", 1.0, 2)


def over_places(name, reward):
    """The answer over all simulators."""
    (found,) = [it for it in RECORDS[name]["over_places"] if it["proposed"] == reward]
    return found


def millimetres(metres):
    """As the page writes it."""
    return f"{1e3 * metres:.3f}" if metres < 1e-3 else f"{1e3 * metres:.1f}"


def apart(one, other):
    """The largest distance of two simulators' tips in each class of motions, in metres."""
    pair = next(it for it in PARITY["pairs"] if (it["a"], it["b"]) == (one, other))
    return [it["max_tip_error_m"] for it in pair["classes"].values()]


def pairs_of_engines():
    """Each two with ideal drives."""
    return [(it["a"], it["b"]) for it in PARITY["pairs"] if SERVO not in it["a"] + it["b"]]


def test_slow_motions_are_within_what_the_page_says():
    """With ideal and with servo drives."""
    slow = [apart(one + drive, other + drive)[0] for one, other in pairs_of_engines() for drive in ("", SERVO)]
    assert max(slow) < 0.2e-3
    assert "all engines are within 0.2 mm" in PROSE


def test_largest_distances_are_told():
    """Of servo drives in fast motions, and after contact."""
    pairs = pairs_of_engines()
    fast = max(apart(one + SERVO, other + SERVO)[2] for one, other in pairs)
    contact = max(apart(one + drive, other + drive)[4] for one, other in pairs for drive in ("", SERVO))
    assert f"up to {millimetres(fast)} mm apart" in PROSE
    assert f"by up to {millimetres(contact)} mm" in PROSE


def test_the_budgets_tell_rewards_apart():
    """The baseline reaches 30 to 90 % of the targets wherever the page does not say that it reaches less."""
    success = {
        (name, place["simulator"]): place["success"]["baseline"]
        for name in RECORDS
        for place in ranking(name)["places"]
    }
    low = {where: value for where, value in success.items() if value < 0.3}
    assert set(low) == {("target-ppo", engine + SERVO) for engine in ("pybullet", "drake", "physx")}
    assert f"{share(min(low.values()))} to {share(max(low.values()))}, in three simulators with servo drives" in PROSE
    assert max(success.values()) <= 0.9


@EACH
def test_page_says_what_was_trained(name):
    """Task, learner, steps, and what the baseline reaches."""
    success = [place["success"]["baseline"] for place in ranking(name)["places"]]
    first = RECORDS[name]["combinations"][0]
    budget = f"`{first['task']}` | `{first['algorithm']}` | {first['steps']:,}"
    assert f"| {name} | {budget} | {share(min(success))} to {share(max(success))} |" in PAGE


@EACH
@EACH_REWARD
def test_page_says_between_what_eta_and_its_parts_lie(name, reward):
    """Over the simulators."""
    cells = []
    for part in ("eta", "ruler", "behaviour"):
        values = [it["eta_N"][part]["value"] for it in combinations(name, reward)]
        cells.append(f"{three(min(values))} to {three(max(values))}")
    assert f"| {name} | {reward} | {' | '.join(cells)} |" in PAGE


@EACH
@EACH_REWARD
def test_page_says_by_how_much_a_reward_is_ahead(name, reward):
    """In how many simulators, between what, and what the answers are."""
    places = [place["success"] for place in ranking(name)["places"]]
    ahead = [100 * (success[reward] - success["baseline"]) for success in places]
    told = f"in {sum(it > 0 for it in ahead)} of {len(ahead)} simulators | {min(ahead):.1f} to {max(ahead):.1f}"
    assert f"| {name} | {reward} | {told} | {kinds(name, reward)} |" in PAGE


@EACH
@EACH_REWARD
def test_page_says_the_answer_over_all_simulators(name, reward):
    """With the means of what decides, and the interval of what did."""
    pool = over_places(name, reward)
    success, time, learning = pool["measures"]
    by = f"{pool['decided_by'].replace('_', ' ')}, {between(decider_of(pool))} " if pool["decided_by"] else ""
    assert time["is_relative"]
    told = [
        pool["answer"].upper(),
        *(share(success[which]) for which in ("baseline", "proposed")),
        f"{100 * (time['proposed'] - time['baseline']):+.0f}%",
        *(share(learning[which]) for which in ("baseline", "proposed")),
    ]
    assert f"| {name} | {reward} | {' | '.join(told)} | {by}|" in PAGE


@EACH
def test_page_says_that_no_choice_misleads(name):
    """Two questions for each pair of simulators; none of them is answered by yes."""
    assert answers(name)["yes"] == 0
    assert f"each of the {len(ranking(name)['pairs'])} pairs" in PROSE
    assert f"these {answers(name).total()} questions" in PROSE


@pytest.mark.parametrize("name", [it for it in RECORDS if it.startswith("reach")])
def test_page_says_that_large_targets_decide_no_choice(name):
    """Ten seeds leave every order open."""
    assert set(answers(name)) == {"not decided"}


@pytest.mark.parametrize("name", [it for it in RECORDS if it.startswith("target")])
def test_page_says_that_dense_is_first_with_small_targets(name):
    """In every simulator."""
    assert all(max(it["success"], key=it["success"].get) == "dense" for it in ranking(name)["places"])


def test_page_says_where_the_robot_contradicts_the_number():
    """`dense` helps over all simulators in three experiments; single ones are decided in one of them."""
    helped = [name for name in RECORDS if over_places(name, "dense")["answer"] == "helps"]
    assert len(helped) == 3
    assert "helps the robot in three of the four experiments" in PROSE
    assert all(over_places(name, "arp")["answer"] == "cannot tell" for name in RECORDS)
    most, *others = sorted(helped, key=lambda name: -over_places(name, "dense")["better_in"])
    pool = over_places(most, "dense")
    over = between(decider_of(pool))
    assert f"better in at least {pool['better_in']} of the 8 simulators ({over} over all)" in PROSE
    pools = [over_places(name, "dense") for name in others]
    told = " and ".join(f"{pool['better_in']} ({between(decider_of(pool), '')})" for pool in pools)
    assert f"better in at least {told} of the 8" in PROSE
    (sooner,) = [name for name in RECORDS if over_places(name, "dense")["answer"] == "learns faster"]
    assert f"in `{sooner}` it learns faster ({between(decider_of(over_places(sooner, 'dense')), '')})" in PROSE


def test_page_names_a_simulator_where_the_robot_contradicts_the_number():
    """The one that is decided by itself."""
    (it,) = decided()
    assert (it["proposed"], it["headline"]["answer"], it["simulator"]) == ("dense", "helps", "drake:drive=servo")
    assert "One row is decided by itself" in PROSE
    assert f"only one of the {sum(len(it['combinations']) for it in RECORDS.values())} is decided by itself" in PROSE
    success = change_of(it, "success_rate")
    values = " instead of ".join(f"{100 * success[which]:.1f} %" for which in ("proposed", "baseline"))
    told = f"success is {values}, and the time to the target is better ({between_times(it)})"
    assert f"{told}, while eta_N is {three(it['eta_N']['eta']['value'])}" in PROSE


@EACH
def test_eta_n_puts_dense_last_everywhere(name):
    """Less counts as better; each difference is beyond chance, as the page says."""
    etas = [place["etas"]["eta_N"]["values"] for place in ranking(name)["places"]]
    assert {max(values, key=values.get) for values in etas} == {"dense"}
    assert {f"{it['eta_N']['p_corrected']:.3f}" for it in combinations(name, "dense")} == {"0.002"}
    assert {round(it["eta_N"]["eta"]["value"]) for it in combinations(name, "dense")} == {2}


def where_moved(matrix):
    """Row and column of each simulator that policies were moved to."""
    simulators = list(enumerate(matrix["trained_in"]))
    return [
        (row, matrix["evaluated_in"].index(there))
        for row, trained_in in simulators
        for _, there in simulators
        if there != trained_in
    ]


def drops():
    """What the success of policies loses in other simulators."""
    return [it["drop"][row][column] for it in TRANSFER["combinations"] for row, column in where_moved(it)]


def test_every_policy_was_moved():
    """Ten seeds of each reward and simulator, and no evaluation failed."""
    assert {it["seeds"] for it in drops()} == {10}
    assert {it["reward"] for it in TRANSFER["combinations"]} == {"baseline", *REWARDS}
    assert TRANSFER["failed"] == []


def test_page_says_how_little_is_lost():
    """The largest drop and rise, the widths of their intervals, and that none leaves 0 out."""
    means, widths = [100 * it["mean"] for it in drops()], [100 * (it["high"] - it["low"]) for it in drops()]
    assert f"drops by {max(means):.1f} points at most and rises by {-min(means):.1f} points at most" in PROSE
    assert f"Each of these {len(means)} drops" in PROSE
    assert f"of {min(widths):.1f} to {max(widths):.1f} points in width" in PROSE
    assert all(it["low"] < 0.0 < it["high"] for it in drops())


def test_page_says_who_succeeds_less():
    """Policies that learned with servo drives, each beside those of the same reward and engine with ideal ones."""
    homes = {
        (it["reward"], trained_in): row[it["evaluated_in"].index(trained_in)]["mean"]
        for it in TRANSFER["combinations"]
        for trained_in, row in zip(it["trained_in"], it["success"], strict=True)
    }
    less = [homes[reward, it + SERVO] < success for (reward, it), success in homes.items() if SERVO not in it]
    assert all(less)
    assert f"in all {len(less)} pairs of reward and engine" in PROSE
