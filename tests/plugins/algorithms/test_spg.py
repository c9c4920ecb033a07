"""SPG: the estimate is the gradient of J; the rest is that a training makes use of it, and can go on."""

import numpy as np
import pytest
import torch
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

import harness
from harness.algorithm import Progress, TrainingState
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.policy import Gaussian, Policy, Uniform
from harness.registry import build
from harness_plugins.algorithms import spg
from harness_plugins.algorithms.spg import Learner, Segment, Spg
from harness_plugins.kit.trainings import ENV_SEED, WatchedEnv, observations, train
from tests.refusals import refused

# ------------------------------------------------------------------- a decision process of two states, solved exactly
# The action is a number; above 0 the process mostly goes to the other state. Nothing else of the action matters, so
# that J depends on the probability of a positive action alone, which a Gaussian has in closed form.

REWARD = np.array([[1.0, -0.5], [-1.0, 2.0]])
"""Of state and choice."""
MOVES = np.array([0.2, 0.9])
"""Probability of the other state, of each choice."""
GAMMA, HORIZON = 0.9, 4
STATES = np.eye(2, dtype=np.float32)
START = np.array([0.7, 0.3])


def _policy(rng):
    layers = spg.draw_layers([2, 3, 1], "mean", 1.0, rng)
    layers["log_std"] = np.array([-0.3], np.float32)
    return {name: torch.tensor(array, dtype=torch.float64, requires_grad=True) for name, array in layers.items()}


def _choices(policy):
    """Probability of each choice in each state, (2, 2)."""
    mean = spg.forward(policy, "tanh", torch.as_tensor(STATES, dtype=torch.float64))[:, 0]
    positive = torch.special.ndtr(mean / policy["log_std"].exp())
    return torch.stack([1.0 - positive, positive], dim=1)


def _objective(policy, horizon=HORIZON):
    """J of NOTE eq. 12, by the matrices of the process: no trials."""
    with torch.no_grad():
        choices = _choices(policy).numpy()
    rewards = (choices * REWARD).sum(axis=1)
    moves = choices @ MOVES
    transition = np.array([[1.0 - moves[0], moves[0]], [moves[1], 1.0 - moves[1]]])
    value = np.zeros(2)
    for _ in range(horizon):
        value = rewards + GAMMA * transition @ value
    return float(START @ value)


def _finite_differences(policy, step=1e-5):
    """The gradient of J, parameter by parameter."""
    slopes = []
    for weight in policy.values():
        for index in np.ndindex(*weight.shape):
            values = []
            for sign in (1.0, -1.0):
                with torch.no_grad():
                    weight[index] += sign * step
                values.append(_objective(policy))
                with torch.no_grad():
                    weight[index] -= sign * step
            slopes.append((values[0] - values[1]) / (2.0 * step))
    return np.array(slopes)


def _trials(policy, count, rng):
    """`count` episodes side by side."""
    state, rows = (rng.random(count) >= START[0]).astype(int), []
    with torch.no_grad():
        mean = spg.forward(policy, "tanh", torch.as_tensor(STATES, dtype=torch.float64))[:, 0].numpy()
        std = float(policy["log_std"].exp())
    for t in range(HORIZON):
        action = mean[state] + std * rng.standard_normal(count)
        choice = (action > 0.0).astype(int)
        rows.append((STATES[state], action[:, None], REWARD[state, choice], np.full(count, t == HORIZON - 1)))
        state = np.where(rng.random(count) < MOVES[choice], 1 - state, state)
    return Segment(*(np.stack(column) for column in zip(*rows, strict=True)), last=STATES[state])


def _estimates(policy, segment, baseline):
    """The estimate from each group of trials, (groups, parameters)."""
    to_go = spg.rewards_to_go(segment.reward, segment.ended, np.zeros(segment.reward.shape[1]), GAMMA)
    weight = (to_go - segment.observation @ baseline) * spg.discounts(segment.ended, GAMMA)
    groups = []
    for part in np.split(np.arange(segment.reward.shape[1]), 20):
        likely = spg.log_prob(
            policy, "tanh", torch.as_tensor(segment.observation[:, part].astype(float)),
            torch.as_tensor(segment.action[:, part]),
        )  # fmt: skip
        mean = spg.surrogate(likely, torch.as_tensor(weight[:, part]))
        slopes = torch.autograd.grad(mean * HORIZON, list(policy.values()))  # a mean over time, J sums
        groups.append(np.concatenate([slope.numpy().ravel() for slope in slopes]))
    return np.array(groups)


@pytest.mark.parametrize("baseline", [(0.0, 0.0), (1.0, 3.0)], ids=["without", "with"])
def test_estimate_is_the_gradient_of_j(baseline):
    """The mean of the estimates is the finite difference of J, solved exactly, within the noise of the trials.

    The noise is measured; that it is small beside the gradient is required, and so is that a wrong sign would be seen.
    """
    rng = default_rng(0)
    policy = _policy(rng)
    exact = _finite_differences(policy)
    groups = _estimates(policy, _trials(policy, 400_000, rng), np.array(baseline))
    noise = groups.std(axis=0, ddof=1) / np.sqrt(len(groups))
    assert (np.abs(groups.mean(axis=0) - exact) < 4.5 * noise + 1e-6).all()
    assert norm(noise) < 0.05 * norm(exact)


def test_baseline_takes_noise_away():
    """Here, where it is near what follows, the estimates scatter less with it."""
    rng = default_rng(1)
    policy = _policy(rng)
    segment = _trials(policy, 20_000, rng)
    expected = spg.rewards_to_go(segment.reward, segment.ended, np.zeros(20_000), GAMMA)[0].mean()
    without, good = (_estimates(policy, segment, np.full(2, level)).std(axis=0) for level in (0.0, expected / 2.0))
    assert norm(good) < norm(without)


# ---------------------------------------------------------------------------------------------------- the equations


def test_log_prob_is_that_of_the_gaussian():
    """Equal to torch's own, NOTE eq. 37 with a diagonal covariance."""
    rng = default_rng(0)
    policy = {name: torch.as_tensor(array) for name, array in spg.draw_layers([4, 8, 3], "mean", 1.0, rng).items()}
    policy["log_std"] = torch.tensor([-1.0, 0.0, 0.5])
    seen, action = (torch.as_tensor(rng.standard_normal((5, size)), dtype=torch.float32) for size in (4, 3))
    normal = torch.distributions.Normal(spg.forward(policy, "tanh", seen), policy["log_std"].exp())
    expected = normal.log_prob(action).sum(dim=-1)
    torch.testing.assert_close(spg.log_prob(policy, "tanh", seen, action), expected)


def _constant_gaussian(mean, variance):
    """One number in, one action, the same in every state."""
    weights = {"mean.weight": [[0.0]], "mean.bias": [mean], "log_std": [0.5 * np.log(variance)]}
    return {name: torch.tensor(values, dtype=torch.float64) for name, values in weights.items()}


STATES_3, ACTIONS_3 = torch.tensor([[-1.0], [2.0]], dtype=torch.float64), torch.tensor([[10.0], [20.0]])
"""Of the NOTE's example 3."""


def test_example_3_of_the_note():
    """Sigma = det Sigma = (s_1 + s_2) / 2 as the NOTE has it, mu by the same rule: pi(a_i | s_i) of eq. 37."""
    sigma, mean = STATES_3.mean().item(), ACTIONS_3.mean().item()
    assert (sigma, mean) == (0.5, 15.0)
    density = spg.log_prob(_constant_gaussian(mean, sigma), "tanh", STATES_3, ACTIONS_3).exp()
    assert_allclose(density, 2 * [np.exp(-25.0) / np.sqrt(np.pi)], rtol=1e-12)
    assert_allclose(density, 2 * [7.84e-12], rtol=1e-3)


def test_example_3_with_the_moments_of_its_actions():
    """The other reading: mean 15 and variance 25."""
    moments = ACTIONS_3.mean().item(), ACTIONS_3.var(correction=0).item()
    density = spg.log_prob(_constant_gaussian(*moments), "tanh", STATES_3, ACTIONS_3).exp()
    assert_allclose(density, 2 * [np.exp(-0.5) / np.sqrt(50.0 * np.pi)], rtol=1e-12)
    assert_allclose(density, 2 * [0.0484], rtol=1e-3)


def test_rewards_to_go_stop_at_the_end_of_an_episode():
    """Discounted within it; behind the last decision comes what is expected, unless the episode ended there."""
    reward = np.array([[1.0, 1.0], [2.0, 2.0], [4.0, 4.0]], np.float32)
    ended = np.array([[False, False], [True, False], [False, True]])
    to_go = spg.rewards_to_go(reward, ended, np.array([8.0, 8.0], np.float32), 0.5)
    assert_allclose(to_go, [[2.0, 3.0], [2.0, 4.0], [8.0, 4.0]])


def test_discounts_begin_anew_with_each_episode():
    """gamma^t."""
    ended = np.array([[False, False], [True, False], [False, False]])
    assert_allclose(spg.discounts(ended, 0.5), [[1.0, 1.0], [0.5, 0.5], [1.0, 0.25]])


# ----------------------------------------------------------------------------------------------------- the training


def test_policy_acts_as_the_net_does():
    """Its mean is the trained net's, clipped to the box."""
    env = WatchedEnv(16)
    env.reset(seed=ENV_SEED)
    learner = Learner(Spg(), env, 3)
    learner.begin()
    learner.update(learner.collect(10_000))
    seen = observations()
    with torch.no_grad():
        mean = spg.forward(learner._policy, "tanh", torch.as_tensor(seen)).numpy()
    assert_allclose(learner.policy().act(seen), np.clip(mean, -1.0, 1.0), atol=1e-6)
    assert mean.std(axis=0).min() > 1e-4


def test_update_climbs_along_the_estimate():
    """What the optimiser is given is the gradient of log pi, weighted by what followed less the baseline."""
    env = WatchedEnv(16)
    env.reset(seed=ENV_SEED)
    learner = Learner(Spg(normalize=False, gamma=0.9), env, 3)
    policy = {name: weight.detach().clone().requires_grad_() for name, weight in learner._policy.items()}
    learner.begin()
    segment = learner.collect(10_000)
    to_go = spg.rewards_to_go(segment.reward, segment.ended, learner._value(segment.last), 0.9)
    weight = torch.as_tensor(to_go - learner._value(segment.observation))
    likely = spg.log_prob(policy, "tanh", torch.as_tensor(segment.observation), torch.as_tensor(segment.action))
    expected = torch.autograd.grad((weight * likely).mean(), list(policy.values()))
    learner.update(segment)
    for slope, (name, trained) in zip(expected, learner._policy.items(), strict=True):
        torch.testing.assert_close(trained.grad, slope)
        assert ((trained - policy[name]).detach() * slope).sum() > 0.0


def test_policy_stays_when_the_training_goes_on():
    """Its weights are copies."""
    env = WatchedEnv(16)
    env.reset(seed=ENV_SEED)
    learner = Learner(Spg(), env, 3)
    policy = learner.policy()
    before = {name: weight.copy() for name, weight in policy.weights.items()}
    learner.begin()
    learner.update(learner.collect(10_000))
    assert all(np.array_equal(policy.weights[name], weight) for name, weight in before.items())
    assert not np.array_equal(learner.policy().weights["mean.weight"], before["mean.weight"])


def test_every_setting_trains_and_matters(subtests):
    """The budget is kept, and other weights come out than with the defaults."""
    for settings in [
        {"baseline": False},
        {"normalize": False},
        {"discount_states": True},
        {"activation": "relu"},
        {"num_envs": 3, "decisions": 7, "restart": 2},
        {"gamma": 1.0},
    ]:
        with subtests.test(settings=settings):
            usual, done = train(Spg(), 1000), train(Spg(**settings), 1000)
            assert done.env.steps == done.told[-1]
            assert not np.array_equal(done.policy.weights["mean.weight"], usual.policy.weights["mean.weight"])


class Watching(Progress):
    """Keeps what it is told, and checkpoints."""

    def __init__(self, state: TrainingState | None = None) -> None:
        self.told: list[tuple[int, dict[str, float]]] = []
        self.states: list[tuple[int, TrainingState]] = []
        self.policies: list[Policy] = []
        self._state = state

    def scalars(self, steps, values):
        self.told.append((steps, dict(values)))

    def policy(self, steps, make):
        self.policies.append(make())

    def checkpoint(self, steps, make):
        self.states.append((steps, make()))

    def restored(self):
        return self._state


def test_training_tells_what_it_does():
    """Both losses and the entropy after each update, and the policy."""
    progress, env = Watching(), WatchedEnv(16)
    env.reset(seed=ENV_SEED)
    Spg().train(env, 960, 0, progress)
    assert [steps for steps, _ in progress.told] == [320, 640, 960]
    names = {"Losses/Policy Loss", "Losses/Value Loss", "Policy/Entropy"}
    assert all(set(values) == names for _, values in progress.told)
    entropy = 6 * (np.log(Spg().std) + 0.5 * np.log(2.0 * np.pi * np.e))
    assert progress.told[0][1]["Policy/Entropy"] == pytest.approx(entropy, abs=0.1)
    assert all(isinstance(policy, Gaussian) for policy in progress.policies)


def test_episodes_start_anew_where_they_would_have():
    """A training that goes on in the middle of a round of updates ends with the same weights, bit for bit."""
    algorithm, through, env = Spg(restart=3), Watching(), WatchedEnv(16)
    env.reset(seed=ENV_SEED)
    states = []
    through.checkpoint = lambda steps, make: states.append((make(), env.state()))  # type: ignore[method-assign]
    whole = algorithm.train(env, 1920, 0, through)
    assert len(states) == 6
    for state, stood in states[:4]:
        again = WatchedEnv(16)
        again.restore(stood)
        resumed = algorithm.train(again, 1920, 0, Watching(state))
        assert all(np.array_equal(resumed.weights[name], whole.weights[name]) for name in whole.weights)


def test_large_seed_is_taken():
    """A seed of 64 bits is no error."""
    assert train(Spg(), 16, seed=2**63).env.steps == 16


def test_bad_setting_is_a_usage_error(subtests):
    """A hyperparameter that cannot be is refused before anything runs."""
    for name in ["learning_rate", "net_arch", "std", "baseline_updates", "decisions", "num_envs"]:
        with subtests.test(name=name), refused(name):
            build(Spg, {name: "" if name == "net_arch" else 0}, "algorithm 'spg'")


# ------------------------------------------------------------------------------------------------- what it learns


def _evaluate(policy):
    """Share of successes and mean return in 100 episodes of the FD100."""
    env, rng = harness.make_env("kinematic", "fd100-reach", "dense", num_envs=100), default_rng(0)
    seen, _ = env.reset(seed=EVALUATION_SEED)
    running, returns, reached = np.ones(100, bool), np.zeros(100), np.zeros(100, bool)
    while running.any():
        seen, paid, terminated, truncated, infos = env.step(policy.act(seen, rng))
        returns += np.where(running, paid, 0.0)
        reached |= running & infos["is_success"]
        running &= ~(terminated | truncated)
    return float(reached.mean()), float(returns.mean())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_defaults_learn_the_fd100_task(seed):
    """In 100,000 steps on the simulator kinematic under the reward dense: success and return far above random."""
    env = harness.make_env("kinematic", "fd100-reach", "dense", num_envs=Spg().num_envs)
    env.reset(seed=seed)
    success, returns = _evaluate(Spg().train(env, 100_000, seed, Progress()))
    floor_success, floor_returns = _evaluate(Uniform((-1.0,) * 6, (1.0,) * 6))
    assert (success > 0.9, floor_success < 0.2) == (True, True)
    assert (returns > -5.0, floor_returns < -40.0) == (True, True)
