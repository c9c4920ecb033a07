"""The rewards of known truth are what they are said to be, and what ``harness audit`` says of each."""

import itertools
from contextlib import closing

import numpy as np
import pytest

import harness
from harness import load_registry
from harness.experiment.environments.plan import columns_of
from harness.payoff.rollout import payoff_of, score_rollout
from harness.record import read_recording
from harness.registry import choose, read_given
from tests.plugins.audit.cases.policies import POLICIES
from tests.plugins.audit.cases.run import SEEDS, answer_of, search
from tests.plugins.audit.cases.table import ARM, HACKED, HONEST, SLIPPERY


def needed(cases):
    """Those that are checked by hand-made policies."""
    return [it for it in cases if it.subject not in (ARM, SLIPPERY)]


def require_engine(case):
    """Skip what needs Gymnasium's MuJoCo environments where these are not installed."""
    if "v5" in case.subject:
        pytest.importorskip("imageio")


def played(case, policy, folder):
    """What it is paid and whether it succeeds: the mean over two episodes, and the last of them."""
    registry = load_registry(given=read_given(case.files))
    environment = choose(registry, "environments", case.subject).build(registry, "environments")
    episodes = []
    for seed in range(2):
        with closing(environment.make()) as env:
            columns = columns_of(environment, env, registry)
            rewards = {case.reward: columns.rewards[case.reward]}
            harness.evaluate_policy(
                POLICIES[policy](), env, folder / f"{policy} {seed}", trained_with=case.reward, seed=0,
                rewards=rewards, behaviour=columns.behaviour, episodes=1, first_seed=seed,
            )  # fmt: skip
        recorded = read_recording(folder / f"{policy} {seed}")
        measure, _, above = (case.success or "success>0.5").partition(">")
        episodes.append((recorded[f"reward/{case.reward}"].sum(), recorded[f"behaviour/{measure}"][-1] > float(above)))
    paid, succeeds = zip(*episodes, strict=True)
    assert len(set(succeeds)) == 1
    return float(np.mean(paid)), bool(succeeds[0])


def lake(ice):
    """Of the policy that is paid most on the slippery lake: its pay, and how often it comes to the goal; exact.

    Args:
        ice: What a step that does not end in a hole pays beside 1 at the goal.
    """
    import gymnasium

    chances = gymnasium.make("FrozenLake-v1").unwrapped.P
    paid, arrived = np.zeros(16), np.zeros(16)
    for _ in range(100):
        ahead = np.zeros((16, 4, 2))
        for state, action in itertools.product(range(16), range(4)):
            for chance, after, goal, is_end in chances[state][action]:
                pays = goal + ice * (not is_end or goal == 1.0)
                ahead[state, action] += chance * np.array(
                    [pays + (not is_end) * paid[after], goal if is_end else arrived[after]]
                )
        best = ahead[..., 0].argmax(axis=1)
        paid, arrived = ahead[np.arange(16), best].T
    return float(paid[0]), float(arrived[0])


@pytest.mark.parametrize("case", needed(HACKED), ids=lambda it: it.name)
def test_a_cheat_is_paid_more_than_good_behaviour(case, tmp_path):
    """It fails, and what it has more is a tenth of what both are paid."""
    require_engine(case)
    (good, succeeds), (cheat, cheats) = (played(case, it, tmp_path) for it in (case.good, *case.others))
    assert succeeds
    assert not cheats
    assert cheat > good + 0.1 * max(abs(cheat), abs(good))


@pytest.mark.parametrize("case", needed(HONEST), ids=lambda it: it.name)
def test_good_behaviour_is_paid_most(case, tmp_path):
    """More than everything else that was thought of, which fails."""
    require_engine(case)
    good, succeeds = played(case, case.good, tmp_path)
    others = [played(case, it, tmp_path) for it in case.others]
    assert succeeds
    assert not any(arrives for _, arrives in others)
    assert all(paid < good for paid, _ in others)


@pytest.mark.parametrize("case", [it for it in (*HACKED, *HONEST) if it.subject == ARM], ids=lambda it: it.name)
def test_scripts_tell_the_truth_of_an_arms_reward(case, rollouts):
    """The cheat is paid more than `finish`, discounted; of an honest reward none of the others is."""
    registry = load_registry(given=read_given(case.files))
    reward = choose(registry, "rewards", case.reward).build(registry, "rewards")
    paid = {it.script: payoff_of(score_rollout(reward, it), 0.95).total_discounted for it in rollouts}
    assert all((paid[it] > paid["finish"]) == (case in HACKED) for it in case.others)


def test_staying_on_the_ice_pays_more_than_the_goal():
    """Whoever is paid most there hardly ever arrives; under the goal's pay alone it arrives as often as anybody can."""
    (_, most), (paid, seldom) = lake(ice=0.0), lake(ice=0.1)
    assert most > 0.7
    assert seldom < 0.5 * most
    assert paid > 2.0


@pytest.mark.slow
@pytest.mark.parametrize("case", [*HACKED, *HONEST], ids=lambda it: it.name)
def test_audit_tells_the_truth(case):
    """A cheat that exists is found, or nothing can be told; where there is none, no alarm is given.

    By one seed, half a minute each; ``python -m tests.plugins.audit.cases.run`` takes three.
    """
    require_engine(case)
    finding, _ = search(case, SEEDS[0])
    assert answer_of(case, finding["answer"]) in ("right", "cannot tell"), finding
