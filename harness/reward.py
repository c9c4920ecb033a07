"""The interface that a reward fills: a pure function of recorded quantities."""

from typing import Any, NamedTuple, Protocol, TypeAlias

Array: TypeAlias = Any
"""A numpy array, or another that answers ``__array_namespace__()`` (JAX)."""

Carry: TypeAlias = Any
"""What a reward remembers inside an episode: an array with a leading num_envs axis, or a tuple of such, or ``()``."""


class Sample(NamedTuple):
    """What the environment tracks at one step, once, for every reward. Arrays of shape (num_envs,)."""

    begin_distance: Array
    """Bd = d(0), NOTE eq. 22, [m]."""
    previous_best: Array
    """Pb, the smallest distance of the episode before this step; Pb(0) = Bd, NOTE eq. 17, [m]."""
    previous_distance: Array
    """d(t-1), [m]."""
    distance: Array
    """d(t), end effector to target after the step, NOTE eq. 14, [m]."""
    delta_distance: Array
    """d(t) - Pb, NOTE eq. 15, [m]."""
    step: Array
    """t, counted from 1 in each episode."""


class Reward(Protocol):
    """A frozen dataclass whose fields are the reward's parameters.

    Calling it must not depend on anything but its arguments and its fields, and must not change its arguments: the
    same function pays the learner step by step and scores whole recorded traces afterwards. The events (ground
    contact, target reached, the step's price) belong to the task and are recorded apart.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """What is remembered at the start of an episode, for envs with these begin distances, shape (num_envs,)."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The carry after the step and the shaped reward of the step, shape (num_envs,)."""
