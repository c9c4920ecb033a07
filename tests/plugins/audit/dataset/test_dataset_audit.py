"""Rewards on recorded behaviour: what they pay, how they rank it, and what is said of that."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.errors import UsageError
from harness.eta.auc import AGAINST, CANNOT_TELL, RANKS
from harness.payoff.dataset import paid_dataset
from harness.payoff.dataset.arm_pay import of_arm
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import Recorded
from harness.payoff.dataset.scores_file import write_dataset_scores
from harness.payoff.dataset.step_by_step import step_by_step
from harness.record.dataset.labels import FAILURE, SUCCESS, UNKNOWN
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness.reward.forms import reward_class
from harness.reward.terms import sum_of
from harness.score.places import parse_places
from harness_plugins.audit.dataset.audit_dataset import audit_dataset
from harness_plugins.datasets import dataset as sizes
from tests.record.dataset.written import episode, opened, write_lerobot, write_minari
from tests.score.test_places import pay_episode

PLACES = "end_effector=0:3,target=3:6"
STEPS = 12


def reaching(number: int, success: bool, waits: int = 0, **attrs):
    """An end effector that comes near its target, or stays away; it stands still for the first steps."""
    one = dict(episode(STEPS, number, success, **attrs))
    way = np.concatenate([np.ones(waits), np.linspace(1.0, 0.01 if success else 0.6, STEPS + 1 - waits)])
    one["observations"] = np.zeros((STEPS + 1, 6))
    one["observations"][:, 0] = way + 0.01 * number
    one["rewards"] = np.where(success, 1.0, -1.0) * np.ones(STEPS)
    return one


@pytest.fixture
def reached(tmp_path: Path) -> str:
    """Ten successes and ten failures."""
    return f"minari:{write_minari(tmp_path / 'reach', [reaching(number, number % 2 == 1) for number in range(20)])}"


def near(observation, action, next_observation, info):
    """The nearer the better."""
    return -float(next_observation[0])


def far(observation, action, next_observation, info):
    """The farther the better."""
    return float(next_observation[0])


def test_a_reward_that_ranks_as_success_does_is_told(reached: str):
    """And one against it, and one that pays all the same."""
    rewards = {"near": near, "far": far, "flat": lambda o, a, n, i: 1.0}
    found = {reward.name: reward for reward in audit_dataset(reached, rewards).rewards}
    assert {name: it.by_success.answer for name, it in found.items()} == {
        "near": RANKS,
        "far": AGAINST,
        "flat": CANNOT_TELL,
    }
    assert found["near"].by_success.value == pytest.approx(1.0)


def test_the_arm_s_rewards_are_paid_by_a_map(reached: str):
    """As an episode by itself is."""
    registry = load_registry()
    arp = choose(registry, "rewards", "arp").build(registry, "rewards")
    places = parse_places(PLACES)
    paid = pay_dataset(opened(reached), {"arp": of_arm(arp, places)}, places)
    seen = reaching(0, False)["observations"]
    expected = pay_episode(arp, places.end_effector(seen), places.target(seen))
    assert paid.paid["arp"][:STEPS] == pytest.approx(expected)
    assert audit_dataset(reached, ["arp"], places=PLACES).rewards[0].by_success.answer == RANKS


@pytest.mark.parametrize("name", ["baseline", "arp", "aarp"])
def test_pieces_do_not_change_the_pay(reached: str, monkeypatch: pytest.MonkeyPatch, name: str):
    """A reward with a memory keeps it from one piece to the next."""
    registry = load_registry()

    def paid():
        places = parse_places(PLACES)
        reward = choose(registry, "rewards", name).build(registry, "rewards")
        return pay_dataset(opened(reached), {"it": of_arm(reward, places), "near": step_by_step("it", near)}, places)

    whole = paid()
    monkeypatch.setattr(sizes, "ROWS", 5)
    pieces = paid()
    assert np.array_equal(whole.paid["it"], pieces.paid["it"])
    assert np.array_equal(whole.paid["near"], pieces.paid["near"])
    assert np.array_equal(whole.begins, pieces.begins)
    assert np.array_equal(whole.told, pieces.told)


def test_a_function_with_a_memory_starts_anew_with_each_episode(reached: str):
    """It is told by ``reset``."""

    class Count:
        steps = 0

        def reset(self):
            self.steps = 0

        def __call__(self, observation, action, next_observation, info):
            self.steps += 1
            return self.steps

    paid = pay_dataset(opened(reached), {"count": step_by_step("it", Count())})
    assert paid.paid["count"][: 2 * STEPS].tolist() == [*range(1, STEPS + 1)] * 2


def test_a_function_gets_what_was_recorded(tmp_path: Path):
    """The info after the step among it."""
    folder = write_minari(tmp_path / "d", [episode(3, 1, success=True)])
    seen = []
    pay_dataset(opened(f"minari:{folder}"), {"see": step_by_step("it", lambda *step: seen.append(step) or 0.0)})
    one = episode(3, 1, success=True)
    seen = seen[::2]  # each step is asked twice
    assert np.array_equal(seen[2][0], one["observations"][2])
    assert np.array_equal(seen[2][1], one["actions"][2])
    assert np.array_equal(seen[2][2], one["observations"][3])
    assert [step[3]["success"] for step in seen] == [False, False, True]


def test_a_reward_that_writes_into_a_step_fails_alone(reached: str):
    """The others go on, and the reason is told."""

    def write(observation, action, next_observation, info):
        observation[0] = 1.0
        return 0.0

    found = audit_dataset(reached, {"write": write, "near": near})
    assert [reward.name for reward in found.rewards] == ["near"]
    assert "read-only" in found.failed["write"]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "x", [1.0, 2.0]])
def test_a_reward_that_pays_no_number_fails_alone(reached: str, value: object):
    """In whatever step."""
    found = audit_dataset(reached, {"odd": lambda o, a, n, i: value, "near": near})
    assert [reward.name for reward in found.rewards] == ["near"]
    assert found.failed["odd"].startswith("episode 0: ")


def test_wrongly_ranked_pairs_are_told_with_their_curves(tmp_path: Path):
    """The worst paid success beside the best paid failure."""
    episodes = [reaching(number, number % 2 == 1) for number in range(8)]
    episodes[3]["rewards"] = np.full(STEPS, -5.0)
    episodes[4]["rewards"] = np.full(STEPS, 5.0)
    (reward,) = audit_dataset(f"minari:{write_minari(tmp_path / 'd', episodes)}").rewards
    assert reward.wrong == 7
    (pair, *_) = reward.pairs
    assert (pair.success, pair.failure, pair.paid) == (3, 4, (-5.0 * STEPS, 5.0 * STEPS))
    assert pair.curves[0].tolist() == (-5.0 * np.arange(1, STEPS + 1)).tolist()


def test_pay_while_nothing_happens_is_told(tmp_path: Path):
    """A reward for being there pays it as any other step; one for progress does not."""
    episodes = [reaching(number, number % 2 == 1, waits=6) for number in range(8)]
    folder = write_minari(tmp_path / "d", episodes)

    def progress(observation, action, next_observation, info):
        return float(observation[0] - next_observation[0])

    found = audit_dataset(f"minari:{folder}", {"there": lambda o, a, n, i: 1.0, "progress": progress})
    there, progressed = (reward.still.mean for reward in found.rewards)
    assert found.still.mean == pytest.approx(5 / 12, abs=0.09)
    assert there == pytest.approx(found.still.mean)
    assert progressed < 0.01


def test_the_steps_paid_most_are_named(tmp_path: Path):
    """One of an episode."""
    episodes = [reaching(number, number % 2 == 1) for number in range(8)]
    episodes[5]["rewards"] = np.arange(STEPS) * 100.0
    (reward,) = audit_dataset(f"minari:{write_minari(tmp_path / 'd', episodes)}").rewards
    assert (reward.most[0].episode, reward.most[0].step, reward.most[0].paid) == (5, 11, 1100.0)


def test_operators_are_what_intervals_are_over(tmp_path: Path):
    """If the data set names them."""
    episodes = [reaching(number, number % 2 == 1, operator=f"o{number // 4}") for number in range(24)]
    found = audit_dataset(f"minari:{write_minari(tmp_path / 'd', episodes)}")
    assert found.clusters == ("operators", 6)
    assert found.rewards[0].by_success.clusters == 6


def test_files_are_what_intervals_are_over_if_asked(tmp_path: Path):
    """LeRobot's first layout has a file for each episode."""
    folder = write_lerobot(tmp_path / "d", [reaching(number, number % 2 == 1) for number in range(8)], "v2.1")
    assert audit_dataset(f"lerobot:{folder}", cluster="file").clusters == ("files", 8)


def test_a_beginner_should_be_paid_less(tmp_path: Path):
    """Whatever succeeded."""
    expert = write_minari(tmp_path / "expert", [reaching(number, True) for number in range(6)])
    beginner = write_minari(tmp_path / "beginner", [reaching(number, False) for number in range(6)])
    (reward,) = audit_dataset(f"minari:{expert}", {"near": near}, beginner=f"minari:{beginner}").rewards
    assert reward.by_level is not None
    assert (reward.by_level.value, reward.by_level.answer) == (1.0, RANKS)
    assert reward.by_success.answer == CANNOT_TELL


def test_two_rewards_are_compared(reached: str):
    """A reward and its negative are opposite."""
    (pair,) = audit_dataset(reached, {"near": near, "far": far}).pairs
    assert pair.steps.mean == pytest.approx(1.0)
    assert pair.discordant.mean == pytest.approx(1.0)
    assert pair.steps.low is not None


def test_episodes_without_a_word_are_left_out(tmp_path: Path):
    """Of success; their steps count elsewhere."""
    episodes = [{**reaching(number, False), "infos": {}} for number in range(4)]
    found = audit_dataset(f"minari:{write_minari(tmp_path / 'd', episodes)}")
    assert (found.successes, found.failures) == (0, 0)
    assert any(line.startswith("Nothing says which episodes succeeded") for line in found.notes)


def test_lerobot_s_last_frame_tells_a_success(tmp_path: Path):
    """And is paid."""
    folder = write_lerobot(tmp_path / "d", [reaching(0, True), reaching(1, False)])
    paid = pay_dataset(opened(f"lerobot:{folder}"), {"recorded": Recorded("recorded")})
    assert paid.told.tolist() == [SUCCESS, FAILURE]
    assert paid.steps == 2 * STEPS
    assert paid.returns["recorded"].tolist() == [STEPS, -STEPS]


@pytest.mark.parametrize("rows", [2, 5])
def test_lerobot_s_batches_do_not_change_the_pay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int):
    """Nor the successes."""
    folder = write_lerobot(tmp_path / "d", [reaching(number, number % 2 == 1) for number in range(5)])

    def paid():
        return pay_dataset(opened(f"lerobot:{folder}"), {"near": step_by_step("it", near)})

    whole = paid()
    monkeypatch.setattr(sizes, "ROWS", rows)
    pieces = paid()
    assert np.array_equal(whole.paid["near"], pieces.paid["near"], equal_nan=True)
    assert np.array_equal(whole.told, pieces.told)


def test_joints_of_a_robot_give_the_end_effector(tmp_path: Path):
    """By its forward kinematics, so that ARP is paid to an arm's log."""
    from harness.robot.robot import load_robot

    robot = load_robot("fd100")
    rng = np.random.default_rng(0)
    joints = rng.uniform(robot.lower, robot.upper, (STEPS + 1, len(robot.lower)))
    one = {**episode(STEPS), "observations": np.hstack([joints, np.tile([0.2, 0.1, 0.3], (STEPS + 1, 1))])}
    dof = len(robot.lower)
    folder = write_minari(tmp_path / "d", [one])
    found = pay_dataset(
        opened(f"minari:{folder}"),
        {
            "arp": of_arm(
                choose(load_registry(), "rewards", "arp").build(load_registry(), "rewards"),
                parse_places(f"joints=0:{dof},target={dof}:{dof + 3}", robot.end_effector),
            )
        },
    )
    arp = choose(load_registry(), "rewards", "arp").build(load_registry(), "rewards")
    expected = pay_episode(arp, robot.end_effector(joints), np.tile([0.2, 0.1, 0.3], (STEPS + 1, 1)))
    assert found.paid["arp"] == pytest.approx(expected)


def test_an_arm_s_reward_without_a_map_is_refused(reached: str):
    """The message shows one."""
    with pytest.raises(UsageError, match="--places end_effector=0:3,target=3:6"):
        audit_dataset(reached, ["arp"])


def test_a_robot_without_a_map_is_refused(reached: str):
    """It would not be used."""
    with pytest.raises(UsageError, match="--places joints=0:6"):
        audit_dataset(reached, ["arp"], robot="fd100")


def test_too_many_steps_are_refused(reached: str, monkeypatch: pytest.MonkeyPatch):
    """What is kept of them would not fit into memory."""
    monkeypatch.setattr(paid_dataset, "MOST_STEPS", 100)
    with pytest.raises(Exception, match="more than 100 steps"):
        audit_dataset(reached)


def test_nothing_is_known_of_an_episode_without_success(tmp_path: Path):
    """It is no failure."""
    folder = write_minari(tmp_path / "d", [{**reaching(0, True), "infos": {}}])
    assert pay_dataset(opened(f"minari:{folder}"), {"near": step_by_step("it", near)}).told.tolist() == [UNKNOWN]


def test_json_has_finite_numbers_only(reached: str):
    """And all that the terminal tells."""
    import json

    told = audit_dataset(reached, {"near": near, "far": far}).to_json()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert [it["success"]["answer"] for it in told["rewards"]] == [RANKS, AGAINST]


def test_the_text_tells_the_answers(reached: str):
    """In the words of the table."""
    text = str(audit_dataset(reached, {"near": near, "far": far}))
    assert "RANKS AS SUCCESS DOES: a success is paid more than a failure with a chance of 1.000" in text
    assert "RANKS AGAINST IT" in text
    assert "shown, never run" in text


def gentle(step):
    """Terms of what there was before and after."""
    return {
        "near": -float(step.observation[0]),
        "went": float(step.before.observation[0] - step.observation[0]),
        "jerk": -float(np.square(step.action - step.before.action).sum()),
    }


def test_terms_of_a_data_set_add_up_to_the_pay(reached: str, monkeypatch: pytest.MonkeyPatch):
    """To the last bit of every step, also where an episode comes in pieces; the first action before is 0."""
    whole = pay_dataset(opened(reached), {"gentle": step_by_step("gentle", gentle)})
    assert np.array_equal(sum_of(whole.terms["gentle"]), whole.paid["gentle"])
    monkeypatch.setattr(sizes, "ROWS", 5)
    pieces = pay_dataset(opened(reached), {"gentle": step_by_step("gentle", gentle)})
    for name, values in whole.terms["gentle"].items():
        assert np.array_equal(values, pieces.terms["gentle"][name])
    action = reaching(0, False)["actions"][0]
    assert whole.terms["gentle"]["jerk"][0] == -float(np.square(action).sum())


def test_terms_stand_in_the_file_of_scores(reached: str, tmp_path: Path):
    """In columns of their own."""
    write_dataset_scores(pay_dataset(opened(reached), {"gentle": step_by_step("gentle", gentle)}), tmp_path / "s")
    columns = pq.read_table(tmp_path / "s").column_names
    assert columns == ["episode", "step", "gentle", "gentle/near", "gentle/went", "gentle/jerk"]


NOT_THERE = {
    "a field": (lambda step: step.distance, "episode 0: A step has no 'distance'. It has: observation, action"),
    "a key": (lambda step: step.info["lost"], "episode 0: info has no 'lost'; it has 'success'"),
    "a key, of four arguments": (lambda o, a, n, i: i["lost"], "episode 0: info has no 'lost'"),
    "the info of the reset": (
        lambda step: float(len(step.before.info)),
        "A step has no 'info'. It has: observation, a",
    ),
    "a sum": (lambda step: (5.0, {"a": 1.0, "b": 2.0}), "The total 5 is not the sum of its terms"),
}


@pytest.mark.parametrize(("reward", "told"), NOT_THERE.values(), ids=NOT_THERE)
def test_what_a_data_set_does_not_have_is_told_by_name(reached: str, reward, told: str):
    """The other rewards go on."""
    paid = pay_dataset(opened(reached), {"it": step_by_step("it", reward), "near": step_by_step("near", near)})
    assert (list(paid.paid), list(paid.failed)) == (["near"], ["it"])
    assert told in paid.failed["it"]


def test_function_of_a_step_may_not_need_the_next_observation(tmp_path: Path):
    """Of the last step nothing is known of that: one that looks is not paid there, the other one is."""
    folder = write_lerobot(tmp_path / "d", [reaching(number, number % 2 == 1) for number in range(5)])
    rewards = {"looks": lambda step: {"it": float(step.observation[0])}, "acts": lambda step: float(step.action[0])}
    paid = pay_dataset(opened(f"lerobot:{folder}"), {n: step_by_step(n, it) for n, it in rewards.items()})
    last = paid.begins[1:] - 1
    assert np.isnan(paid.paid["looks"][last]).all()
    assert np.isnan(paid.terms["looks"]["it"][last]).all()
    assert np.isfinite(paid.paid["acts"]).all()


def test_an_arm_s_reward_reads_what_a_data_set_has(reached: str):
    """The action, and before the first step zeros; not speeds, which it does not have."""

    def effort(step):
        return {"near": -step.distance, "jerk": -((step.action - step.before.action) ** 2).sum(-1)}

    def speeds(step):
        return -(step.qvel**2).sum(-1)

    places = parse_places(PLACES)
    rewards = {it.__name__: of_arm(reward_class(it)(), places) for it in (effort, speeds)}
    paid = pay_dataset(opened(reached), rewards, places)
    assert np.array_equal(sum_of(paid.terms["effort"]), paid.paid["effort"])
    action = np.asarray(reaching(0, False)["actions"], float)
    expected = -np.square(np.diff(action, axis=0, prepend=0.0 * action[:1])).sum(axis=1)
    assert paid.terms["effort"]["jerk"][:STEPS] == pytest.approx(expected)
    assert "has no 'qvel'" in paid.failed["speeds"]
