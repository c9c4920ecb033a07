"""Every algorithm goes on from its checkpoints as if nothing had happened, whatever the simulator."""

import pytest

from harness.env.vector_env import World
from harness.registry import choose
from harness.registry.choice import build_defaults
from harness_plugins.kit.algorithms import differences, train_with_checkpoints
from tests.registered import FD100, REGISTRY

SMALL = {"net_arch": (8,), "batch_size": 16, "learning_starts": 40}
ALGORITHMS = {
    "sac-fast": {**SMALL, "buffer_size": 60},
    "sb3-sac": SMALL,
    "td3": SMALL,
    "dqn": SMALL,
    "ddqn": SMALL,
    "ppo": {"net_arch": (8,), "batch_size": 16, "rollout": 48},
    "spg": {"net_arch": (8,), "decisions": 9},
    "random": {},
    "ik": {},
}
STEPS, EVERY = 198, 70
CASES = [
    pytest.param(algorithm, simulator, num_envs, marks=[pytest.mark.slow] * (algorithm != "sac-fast"))
    for algorithm in ALGORITHMS
    for simulator in REGISTRY.names("simulators")
    for num_envs in (1, 3)
]


@pytest.mark.parametrize(("algorithm", "simulator", "num_envs"), CASES)
def test_training_goes_on_as_if_nothing_had_happened(installed, tmp_path, algorithm, simulator, num_envs):
    """From the middle of episodes: the same steps, weights and scalars as one that made no checkpoints."""

    def open_env(learner):
        task = {"name": "fd100-reach", "horizon": 25}
        if learner.action_spaces == {"discrete"}:
            task["action"] = "discrete"
        built = choose(REGISTRY, "tasks", task).build(REGISTRY, "tasks")
        engine = REGISTRY.get("simulators", simulator).load()()
        world = World(engine, FD100, built, build_defaults(REGISTRY, "rewards")["baseline"])
        return world.open(learner.num_envs, resumable=True)

    def train(name, every=EVERY, start=None):
        return train_with_checkpoints(learner, STEPS, every, tmp_path / name, start, open_env)

    learner = REGISTRY.get("algorithms", algorithm).load()(**ALGORITHMS[algorithm], num_envs=num_envs)
    plain, whole = train("plain", 2 * STEPS), train("whole")
    assert differences(plain, whole) == ""
    assert len(whole.left) == 2
    for left in whole.left:
        again = train(f"from-{left.steps}", start=left)
        assert differences(plain, again, left) == ""
        assert again.scalars == [told for told in plain.scalars if told[0] > left.steps]
