"""Every registered reward pays JAX arrays as it pays numpy's, compiled and mapped too."""

import numpy as np
import pytest

from harness.registry.registry import load_registry
from harness.reward import Carry, Reward, Sample
from harness.testing.rewards.samples import edge_samples, play, random_samples

jax = pytest.importorskip("jax")

REGISTRY = load_registry()
SETTINGS = ["relative:denominator=current", "scaled:reward=aarp:growth=1.5", "shifted:reward=relative"]
"""Ways through a reward that its defaults leave out, and carries that another reward hands on."""

every_reward = pytest.mark.parametrize("name", [*REGISTRY.names("rewards"), *SETTINGS])
both_precisions = pytest.mark.parametrize(("x64", "tolerance"), [(False, 1e-6), (True, 1e-12)])


def build(name: str) -> Reward:
    """A registered reward."""
    from harness.registry.choice import choose

    return choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")


def stacked(samples: list[Sample], x64: bool) -> Sample:
    """A sample whose arrays are (steps, num_envs), in single or double precision."""
    return Sample(*(np.stack(parts).astype(np.float64 if x64 else np.float32) for parts in zip(*samples, strict=True)))


def pay_all(reward: Reward, begin: object, samples: Sample) -> object:
    """What the steps pay, (steps, num_envs), by a loop that JAX compiles."""

    def step(carry: Carry, sample: Sample) -> tuple[Carry, object]:
        return reward(carry, sample)

    return jax.lax.scan(step, reward.initial_carry(begin), samples)[1]


def assert_near(told: object, known: np.ndarray, tolerance: float, x64: bool) -> None:
    """Up to rounding: of a value, and of one metre."""
    assert told.dtype == (np.float64 if x64 else np.float32)
    np.testing.assert_allclose(np.asarray(told), known, rtol=tolerance, atol=tolerance)


@every_reward
@both_precisions
def test_compiled_trajectory_is_paid_as_by_numpy(name: str, x64: bool, tolerance: float):
    """Under jit a scan over random episodes pays what numpy pays step by step."""
    reward, samples = build(name), random_samples(0)
    known = np.stack(play(reward, samples)[1])
    with jax.enable_x64(x64):
        given = stacked(samples, x64)
        told = jax.jit(lambda begin, steps: pay_all(reward, begin, steps))(given.begin_distance[0], given)
        assert_near(told, known, tolerance, x64)


@every_reward
@both_precisions
def test_mapped_envs_are_paid_as_by_numpy(name: str, x64: bool, tolerance: float):
    """Under jit and vmap every env of a batch is paid what numpy pays it."""
    reward, samples = build(name), random_samples(1)
    known = np.stack(play(reward, samples)[1])
    with jax.enable_x64(x64):
        given = Sample(*(part[:, :, None] for part in stacked(samples, x64)))  # (steps, envs, 1): mapped over the envs
        mapped = jax.vmap(lambda begin, steps: pay_all(reward, begin, steps), in_axes=(0, 1), out_axes=1)
        assert_near(jax.jit(mapped)(given.begin_distance[0], given)[..., 0], known, tolerance, x64)


@every_reward
def test_edges_are_finite(name: str):
    """Where a distance or a gain is exactly 0, single precision pays finite numbers too."""
    reward = build(name)
    given = stacked(edge_samples(), x64=False)
    assert np.isfinite(
        np.asarray(jax.jit(lambda begin, steps: pay_all(reward, begin, steps))(given.begin_distance[0], given))
    ).all()
