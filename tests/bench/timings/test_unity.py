"""What the env of a Unity program costs beside the bare loop of ML-Agents, with the same player at the other end."""

import statistics
import time
import warnings

import numpy as np
import pytest
from numpy.random import default_rng

from harness.environment import announce_all
from harness.registry.allowed import PROGRAMS, allow_programs

pytestmark = pytest.mark.bench
ROUNDS = 5


def _bare(program, agents, steps):
    """ML-Agents' own environment, every agent of which acts in each step."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        from mlagents_envs.base_env import ActionTuple
        from mlagents_envs.environment import UnityEnvironment

        env = UnityEnvironment(str(program), base_port=5105 + agents, no_graphics=True)
    env.reset()
    (name,) = env.behavior_specs
    rng = default_rng(0)

    def play():
        for _ in range(steps):
            decisions, _ = env.get_steps(name)
            assert len(decisions) == agents
            env.set_actions(name, ActionTuple(rng.uniform(-1, 1, (len(decisions), 5)).astype(np.float32)))
            env.step()

    play.close = env.close  # type: ignore[attr-defined]
    return play


def _ours(program, agents, steps):
    from harness_plugins.environments.unity import Unity

    envs = Unity(file=str(program)).make_together(agents)
    for env in envs:
        env.reset(seed=0)
    rng = default_rng(0)

    def play():
        for _ in range(steps):
            actions = list(rng.uniform(-1, 1, (agents, 5)).astype(np.float32))
            announce_all(envs, actions)
            for env, action in zip(envs, actions, strict=True):
                _, _, terminated, truncated, _ = env.step(action)
                if terminated or truncated:
                    env.reset()

    play.close = lambda: [env.close() for env in envs]  # type: ignore[attr-defined]
    return play


@pytest.mark.parametrize("agents", [1, 8])
def test_steps_beside_the_bare_loop(tmp_path, require_ratio, amount, agents, monkeypatch):
    """Wall time, for two processes wait for each other; they take turns, and the median of the turns' ratios counts."""
    try:
        import harness_plugins.unity_player.connection  # noqa: F401
    except (ImportError, TypeError):
        pytest.skip("mlagents-envs and its protobuf are not installed here: make unity")
    from harness_plugins.kit.unity_player import write_unity_player

    program = write_unity_player(tmp_path / "player", ["--agents", str(agents)])
    monkeypatch.setenv(PROGRAMS, "")
    allow_programs([str(program)])
    steps = amount(500, 5)
    bare, ours = _bare(program, agents, steps), _ours(program, agents, steps)
    seconds = {bare: [], ours: []}
    try:
        for _ in range(amount(ROUNDS, 1)):
            for play, took in seconds.items():
                start = time.perf_counter()
                play()
                took.append(time.perf_counter() - start)
    finally:
        bare.close()  # type: ignore[attr-defined]
        ours.close()  # type: ignore[attr-defined]
    ratio = statistics.median(first / second for first, second in zip(seconds[bare], seconds[ours], strict=True))
    told = f"({steps / statistics.median(seconds[ours]):,.0f} steps/s)"
    require_ratio(ratio, at_least=0.9, told=told)
