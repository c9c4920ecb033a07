"""Every registered reward, and functions of full steps, pay JAX arrays as numpy's, compiled and mapped too."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.reward import pay
from harness.reward.forms import reward_class
from harness.reward.steps import map_steps
from harness_plugins.kit.reward_samples import edge_samples, play, random_samples, values_of
from tests.registered import REGISTRY

jax = pytest.importorskip("jax")

SETTINGS = ["relative:denominator=current", "scaled:reward=aarp:growth=1.5", "shifted:reward=relative"]
"""Ways through a reward that its defaults leave out, and carries that another reward hands on."""


def gentle(step):
    """Every field, now and before, by methods that all arrays have."""
    speed = (step.qvel**2).sum(-1) - (step.before.qvel**2).mean(-1)
    jerk = ((step.action - step.before.action) ** 2).sum(-1)
    way = abs(step.end_effector - step.before.end_effector).max(axis=1) + step.target.min(-1)
    bent = step.qpos.sum(-1) - step.before.qpos.sum(-1) + (step.before.qpos > 0.1).any(-1)
    touched = -1.0 * step.ground - 0.5 * step.before.ground
    return {"reach": -step.distance, "speed": speed, "jerk": -0.1 * jerk, "way": way, "bent": bent, "touched": touched}


def gained(step):
    """A total beside its terms, by the functions of the arrays' own library."""
    xp = step.distance.__array_namespace__()
    near = xp.exp(-step.distance)
    gain = xp.where(step.delta_distance < 0.0, step.before.distance - step.distance, 0.0)
    return near + gain, {"near": near, "gain": gain}


FUNCTIONS = {function.__name__: function for function in (gentle, gained)}
every_reward = pytest.mark.parametrize("name", [*REGISTRY.names("rewards"), *SETTINGS, *FUNCTIONS])
both_precisions = pytest.mark.parametrize(("x64", "tolerance"), [(False, 1e-6), (True, 1e-12)])


def build(name):
    """A registered reward, or one of the functions."""
    from harness.registry import choose

    if name in FUNCTIONS:
        return reward_class(FUNCTIONS[name])()
    return choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")


def stacked(samples, x64):
    """Steps whose arrays are (steps, num_envs, ...), in single or double precision: JAX takes steps for a tree."""

    def stack(*parts):
        whole = np.stack(parts)
        return whole if whole.dtype == bool else whole.astype(np.float64 if x64 else np.float32)

    return jax.tree.map(stack, *samples)


def pay_all(reward, begin, samples):
    """What the steps pay in all and by term, (steps, num_envs), by a loop that JAX compiles."""

    def step(carry, steps):
        after, paid = pay(reward, carry, steps)
        return after, values_of(paid)

    return jax.lax.scan(step, reward.initial_carry(begin), samples)[1]


def paid_by_numpy(reward, samples):
    """The same, step by step."""
    return jax.tree.map(lambda *values: np.stack(values), *map(values_of, play(reward, samples)[1]))


def assert_near(told, known, tolerance, x64):
    """Up to rounding: of a value, and of one metre."""
    assert told.keys() == known.keys()
    for name, values in told.items():
        assert values.dtype == (np.float64 if x64 else np.float32)
        assert_allclose(np.asarray(values), known[name], rtol=tolerance, atol=tolerance)


@every_reward
@both_precisions
def test_compiled_trajectory_is_paid_as_by_numpy(name, x64, tolerance):
    """Under jit a scan over random episodes pays what numpy pays step by step."""
    reward, samples = build(name), random_samples(0)
    known = paid_by_numpy(reward, samples)
    with jax.enable_x64(x64):
        given = stacked(samples, x64)
        told = jax.jit(lambda begin, steps: pay_all(reward, begin, steps))(given.begin_distance[0], given)
        assert_near(told, known, tolerance, x64)


@every_reward
@both_precisions
def test_mapped_envs_are_paid_as_by_numpy(name, x64, tolerance):
    """Under jit and vmap every env of a batch is paid what numpy pays it."""
    reward, samples = build(name), random_samples(1)
    known = paid_by_numpy(reward, samples)
    with jax.enable_x64(x64):
        given = map_steps(
            lambda part: part[:, :, None], stacked(samples, x64)
        )  # (steps, envs, 1, ...): mapped over envs
        mapped = jax.vmap(lambda begin, steps: pay_all(reward, begin, steps), in_axes=(0, 1), out_axes=1)
        told = jax.jit(mapped)(given.begin_distance[0], given)
        assert_near({name: values[..., 0] for name, values in told.items()}, known, tolerance, x64)


@every_reward
def test_edges_are_finite(name):
    """Where a distance or a gain is exactly 0, single precision pays finite numbers too."""
    reward = build(name)
    given = stacked(edge_samples(), x64=False)
    told = jax.jit(lambda begin, steps: pay_all(reward, begin, steps))(given.begin_distance[0], given)
    assert all(np.isfinite(np.asarray(values)).all() for values in told.values())


def test_a_function_of_numpy_does_not_compile():
    """The kit's warning is right: JAX refuses what `reward-numpy` warns of."""

    def with_numpy(step):
        return np.exp(-step.distance)

    reward, given = reward_class(with_numpy)(), stacked(random_samples(0), x64=False)
    with pytest.raises(jax.errors.TracerArrayConversionError):
        jax.jit(lambda begin, steps: pay_all(reward, begin, steps))(given.begin_distance[0], given)
