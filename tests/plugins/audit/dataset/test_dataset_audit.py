"""Rewards on recorded behaviour: what they pay, how they rank it, and what is said of that."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.random import default_rng

from harness.payoff.dataset import paid_dataset
from harness.payoff.dataset.arm_pay import of_arm
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import Recorded
from harness.payoff.dataset.scores_file import write_dataset_scores
from harness.payoff.dataset.step_by_step import step_by_step
from harness.record.dataset.labels import FAILURE, SUCCESS, UNKNOWN
from harness.reward.forms import reward_class
from harness.reward.terms import sum_of
from harness.score.places import ArmPay, parse_places
from harness_plugins.audit import audit_dataset
from harness_plugins.datasets import dataset as sizes
from tests.payoff.conftest import named
from tests.record.dataset.written import episode, opened, write_lerobot, write_minari
from tests.refusals import refused
from tests.registered import FD100

RANKS, AGAINST, CANNOT_TELL = "RANKS AS SUCCESS DOES", "RANKS AGAINST IT", "CANNOT TELL"
PLACES = "end_effector=0:3,target=3:6"
STEPS = 12


def reaching(number, success=None, waits=0, **attrs):
    """An end effector that comes near its target, or stays away; it stands still for the first steps."""
    success = number % 2 == 1 if success is None else success
    one = dict(episode(STEPS, number, success, **attrs))
    way = np.concatenate([np.ones(waits), np.linspace(1.0, 0.01 if success else 0.6, STEPS + 1 - waits)])
    one["observations"] = np.zeros((STEPS + 1, 6))
    one["observations"][:, 0] = way + 0.01 * number
    one["rewards"] = np.where(success, 1.0, -1.0) * np.ones(STEPS)
    return one


@pytest.fixture
def minari(tmp_path):
    """The name of a Minari data set of such episodes."""
    return lambda episodes, name="d": f"minari:{write_minari(tmp_path / name, episodes)}"


@pytest.fixture
def lerobot(tmp_path):
    """The name of a LeRobot data set of so many episodes."""
    return lambda count, *how: f"lerobot:{write_lerobot(tmp_path / 'd', [reaching(it) for it in range(count)], *how)}"


@pytest.fixture
def reached(minari):
    """Ten successes and ten failures."""
    return minari([reaching(number) for number in range(20)])


def near(observation, action, next_observation, info):
    """The nearer the better."""
    return -float(next_observation[0])


def far(observation, action, next_observation, info):
    """The farther the better."""
    return float(next_observation[0])


def pay(dataset, places=None, **rewards):
    """Functions, and rewards of an arm by a map, are paid to a data set."""
    asked = {name: step_by_step(name, it) if callable(it) and places is None else it for name, it in rewards.items()}
    return pay_dataset(opened(dataset), asked, places)


def pay_episode(reward, end_effector, target):
    """What an arm's reward pays each step of an episode, by positions before each step and after the last."""
    arm, far = ArmPay(reward), np.linalg.norm(end_effector - target, axis=1)
    arm.begin(far[0])
    return arm.pay(far[1:]).total


def test_a_reward_that_ranks_as_success_does_is_told(reached):
    """And one against it, and one that pays all the same: as an object, in words, and as JSON of finite numbers."""
    found = audit_dataset(reached, {"near": near, "far": far, "flat": lambda o, a, n, i: 1.0})
    assert [it.by_success.answer for it in found.rewards] == [RANKS, AGAINST, CANNOT_TELL]
    assert found.rewards[0].by_success.value == pytest.approx(1.0)
    told, text = found.to_json(), str(found)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert [it["success"]["answer"] for it in told["rewards"]] == [RANKS, AGAINST, CANNOT_TELL]
    assert f"{RANKS}: a success is paid more than a failure with a chance of 1.000" in text
    assert AGAINST in text
    assert "shown, never run" in text
    pair = found.pairs[0]
    assert (pair.steps.value, pair.discordant.value) == (pytest.approx(1.0), pytest.approx(1.0))
    assert pair.steps.low is not None


def test_the_arm_s_rewards_are_paid_by_a_map(reached):
    """As an episode by itself is."""
    arp, places = named("arp"), parse_places(PLACES)
    paid = pay(reached, places, arp=of_arm(arp, places))
    seen = reaching(0)["observations"]
    expected = pay_episode(arp, places.end_effector(seen), places.target(seen))
    assert paid.paid["arp"][:STEPS] == pytest.approx(expected)
    assert audit_dataset(reached, ["arp"], places=PLACES).rewards[0].by_success.answer == RANKS


def gentle(step):
    """Terms of what there was before and after."""
    return {
        "near": -float(step.observation[0]),
        "went": float(step.before.observation[0] - step.observation[0]),
        "jerk": -float(np.square(step.action - step.before.action).sum()),
    }


@pytest.mark.parametrize("name", ["baseline", "arp", "aarp"])
def test_pieces_do_not_change_the_pay(reached, monkeypatch, name):
    """A reward with a memory keeps it from one piece to the next; terms add up to the last bit of every step."""
    places = parse_places(PLACES)
    rewards = {"it": of_arm(named(name), places), **{it.__name__: step_by_step("it", it) for it in (near, gentle)}}
    whole = pay(reached, places, **rewards)
    monkeypatch.setattr(sizes, "ROWS", 5)
    pieces = pay(reached, places, **rewards)
    for reward in rewards:
        assert np.array_equal(whole.paid[reward], pieces.paid[reward])
    assert np.array_equal(whole.begins, pieces.begins)
    assert np.array_equal(whole.each("success"), pieces.each("success"))
    assert np.array_equal(sum_of(whole.terms["gentle"]), whole.paid["gentle"])
    for term, values in whole.terms["gentle"].items():
        assert np.array_equal(values, pieces.terms["gentle"][term])
    assert whole.terms["gentle"]["jerk"][0] == -float(np.square(reaching(0)["actions"][0]).sum())


def test_a_function_with_a_memory_starts_anew_with_each_episode(reached):
    """It is told by ``reset``."""

    class Count:
        def reset(self):
            self.steps = 0

        def __call__(self, observation, action, next_observation, info):
            self.steps += 1
            return self.steps

    assert pay(reached, count=Count()).paid["count"][: 2 * STEPS].tolist() == [*range(1, STEPS + 1)] * 2


def test_a_function_gets_what_was_recorded(minari):
    """The info after the step among it."""
    one, seen = episode(3, 1, success=True), []
    pay(minari([one]), see=lambda *step: seen.append(step) or 0.0)
    seen = seen[:3]  # all of them are asked again after that
    for part, expected in enumerate((one["observations"][2], one["actions"][2], one["observations"][3])):
        assert np.array_equal(seen[2][part], expected)
    assert [step[3]["success"] for step in seen] == [False, False, True]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "x", [1.0, 2.0], None])
def test_a_reward_that_pays_no_number_fails_alone(reached, value):
    """In whatever step, or because it writes into one; the others go on, and the reason is told."""

    def odd(observation, action, next_observation, info):
        if value is None:
            observation[0] = 1.0
        return value

    found = audit_dataset(reached, {"odd": odd, "near": near})
    assert [reward.name for reward in found.rewards] == ["near"]
    assert ("read-only" if value is None else "episode 0: ") in found.failed["odd"]


def test_wrongly_ranked_pairs_and_the_steps_paid_most_are_told(minari):
    """The worst paid success beside the best paid failure, with their curves; one step of an episode."""
    episodes = [reaching(number) for number in range(8)]
    episodes[3]["rewards"] = np.full(STEPS, -5.0)
    episodes[4]["rewards"] = np.arange(STEPS) * 100.0
    (reward,) = audit_dataset(minari(episodes)).rewards
    assert reward.wrong == 7
    (pair, *_) = reward.pairs
    assert (pair.success, pair.failure, pair.paid) == (3, 4, (-5.0 * STEPS, 100.0 * sum(range(STEPS))))
    assert pair.curves[0].tolist() == (-5.0 * np.arange(1, STEPS + 1)).tolist()
    assert (reward.most[0].episode, reward.most[0].step, reward.most[0].paid) == (4, 11, 1100.0)


def test_pay_while_nothing_happens_is_told(minari):
    """A reward for being there pays it as any other step; one for progress does not."""
    name = minari([reaching(number, waits=6) for number in range(8)])
    found = audit_dataset(name, {"there": lambda o, a, n, i: 1.0, "progress": lambda o, a, n, i: float(o[0] - n[0])})
    there, progressed = (reward.still.value for reward in found.rewards)
    assert found.still.value == pytest.approx(5 / 12, abs=0.09)
    assert there == pytest.approx(found.still.value)
    assert progressed < 0.01


def test_operators_are_what_intervals_are_over(minari):
    """If the data set names them."""
    found = audit_dataset(minari([reaching(number, operator=f"o{number // 4}") for number in range(24)]))
    assert (found.clusters, found.rewards[0].by_success.clusters) == (("operators", 6), 6)


def test_files_are_what_intervals_are_over_if_asked(lerobot):
    """LeRobot's first layout has a file for each episode."""
    assert audit_dataset(lerobot(8, "v2.1"), cluster="file").clusters == ("files", 8)


def test_a_beginner_should_be_paid_less(minari):
    """Whatever succeeded."""
    expert, beginner = (minari([reaching(it, able) for it in range(6)], f"{able}") for able in (True, False))
    (reward,) = audit_dataset(expert, {"near": near}, beginner=beginner).rewards
    assert (reward.by_level.value, reward.by_level.answer, reward.by_success.answer) == (1.0, RANKS, CANNOT_TELL)


def test_episodes_without_a_word_are_left_out(minari):
    """Of success; they are no failures, and their steps count elsewhere."""
    name = minari([{**reaching(number), "infos": {}} for number in range(4)])
    found = audit_dataset(name)
    assert (found.successes, found.failures) == (0, 0)
    assert any(line.startswith("Nothing says which episodes succeeded") for line in found.notes)
    assert pay(name, near=near).each("success").tolist() == [UNKNOWN] * 4


@pytest.mark.parametrize("rows", [2, 5])
def test_lerobot_s_batches_do_not_change_the_pay(lerobot, monkeypatch, rows):
    """Nor the successes. The last frame tells one, and its recorded pay counts."""
    name = lerobot(5)
    recorded = pay_dataset(opened(name), {"recorded": Recorded("recorded")})
    assert recorded.each("success").tolist() == [FAILURE, SUCCESS, FAILURE, SUCCESS, FAILURE]
    assert recorded.returns["recorded"].tolist() == [-STEPS, STEPS, -STEPS, STEPS, -STEPS]
    whole = pay(name, near=near)
    monkeypatch.setattr(sizes, "ROWS", rows)
    pieces = pay(name, near=near)
    assert np.array_equal(whole.paid["near"], pieces.paid["near"], equal_nan=True)
    assert np.array_equal(whole.each("success"), pieces.each("success"))


def test_function_of_a_step_may_not_need_the_next_observation(lerobot):
    """Of the last step nothing is known of that: one that looks is not paid there, the other one is."""
    rewards = {"looks": lambda step: {"it": float(step.observation[0])}, "acts": lambda step: float(step.action[0])}
    paid = pay(lerobot(5), **rewards)
    last = paid.begins[1:] - 1
    assert np.isnan(paid.paid["looks"][last]).all()
    assert np.isnan(paid.terms["looks"]["it"][last]).all()
    assert np.isfinite(paid.paid["acts"]).all()


def test_joints_of_a_robot_give_the_end_effector(minari):
    """By its forward kinematics, so that ARP is paid to an arm's log."""
    robot, arp = FD100, named("arp")
    target = np.tile([0.2, 0.1, 0.3], (STEPS + 1, 1))
    joints = default_rng(0).uniform(robot.lower, robot.upper, (STEPS + 1, robot.dof))
    places = parse_places(f"joints=0:{robot.dof},target={robot.dof}:{robot.dof + 3}", robot.end_effector)
    name = minari([{**episode(STEPS), "observations": np.hstack([joints, target])}])
    expected = pay_episode(arp, robot.end_effector(joints), target)
    assert pay(name, places, arp=of_arm(arp, places)).paid["arp"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("more", "told"), [({}, "--places end_effector=0:3,target=3:6"), ({"robot": "fd100"}, "--places joints=0:6")]
)
def test_an_arm_s_reward_without_a_map_is_refused(reached, more, told):
    """The message shows one; a robot would not be used either."""
    with refused(told):
        audit_dataset(reached, ["arp"], **more)


def test_too_many_steps_are_refused(reached, monkeypatch):
    """What is kept of them would not fit into memory."""
    monkeypatch.setattr(paid_dataset, "MOST_STEPS", 100)
    with pytest.raises(Exception, match="more than 100 steps"):
        audit_dataset(reached)


def test_terms_stand_in_the_file_of_scores(reached, tmp_path):
    """In columns of their own."""
    write_dataset_scores(pay(reached, gentle=gentle), tmp_path / "s")
    columns = pq.read_table(tmp_path / "s").column_names
    assert columns == ["episode", "step", "gentle", "gentle/near", "gentle/went", "gentle/jerk"]


NOT_THERE = {
    "a field": (lambda step: step.distance, "episode 0: A step has no 'distance'. It has: observation, action"),
    "a key": (lambda step: step.info["lost"], "episode 0: info has no 'lost'; it has 'success'"),
    "a key, of four arguments": (lambda o, a, n, i: i["lost"], "episode 0: info has no 'lost'"),
    "the info of the reset": (lambda step: len(step.before.info), "A step has no 'info'. It has: observation, a"),
    "a sum": (lambda step: (5.0, {"a": 1.0, "b": 2.0}), "The total 5 is not the sum of its terms"),
}


@pytest.mark.parametrize(("reward", "told"), NOT_THERE.values(), ids=NOT_THERE)
def test_what_a_data_set_does_not_have_is_told_by_name(reached, reward, told):
    """The other rewards go on."""
    paid = pay(reached, it=reward, near=near)
    assert (list(paid.paid), list(paid.failed)) == (["near"], ["it"])
    assert told in paid.failed["it"]


def test_an_arm_s_reward_reads_what_a_data_set_has(reached):
    """The action, and before the first step zeros; not speeds, which it does not have."""

    def effort(step):
        return {"near": -step.distance, "jerk": -((step.action - step.before.action) ** 2).sum(-1)}

    def speeds(step):
        return -(step.qvel**2).sum(-1)

    places = parse_places(PLACES)
    paid = pay(reached, places, **{it.__name__: of_arm(reward_class(it)(), places) for it in (effort, speeds)})
    assert np.array_equal(sum_of(paid.terms["effort"]), paid.paid["effort"])
    action = np.asarray(reaching(0)["actions"], float)
    expected = -np.square(np.diff(action, axis=0, prepend=0.0 * action[:1])).sum(axis=1)
    assert paid.terms["effort"]["jerk"][:STEPS] == pytest.approx(expected)
    assert "has no 'qvel'" in paid.failed["speeds"]
