"""What a search for cheats costs beside a plain loop of as many steps in the same environment."""

import gymnasium
import pytest

from harness_plugins.audit import find_cheats

pytestmark = pytest.mark.bench


def stands(observation, action, next_observation, info):
    """Whether the pendulum stands."""
    return bool(next_observation[0] > 0.95 and abs(next_observation[2]) < 1.0)


def survives(observation, action, next_observation, info):
    """Whether the cart is near the middle."""
    return bool(abs(next_observation[0]) < 0.5)


@pytest.mark.parametrize(("name", "success", "share"), [("Pendulum-v1", stands, 0.3), ("CartPole-v1", survives, 0.1)])
def test_a_search_costs_little_beside_its_steps(require_speed, amount, name, success, share):
    """Rewards and measures are asked in every step, and actions are bred; the environment's own steps cost most."""
    steps = amount(60_000, 2_000)
    env = gymnasium.make(name)

    def loop():
        env.reset(seed=0)
        env.action_space.seed(0)
        for _ in range(steps):
            _, _, terminated, truncated, _ = env.step(env.action_space.sample())
            if terminated or truncated:
                env.reset()

    def search():
        found = find_cheats(name, {"own": "own"}, behaviour={"success": success}, budget=steps, starts=2)
        assert found.cheats[0].searched.steps > 0.5 * steps

    require_speed(loop, search, at_least=share, rounds=5)
