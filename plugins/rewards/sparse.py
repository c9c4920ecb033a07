"""No shaping at all."""

from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Sparse:
    """Pays nothing: what the task pays for its events, ground, target and step, is all there is.

        r = 0

    The events are NOTE eq. 18 (ground), 19 and 20 (target); they are recorded apart from the shaped reward. Bounded and
    scale-free, and the best policy under it is what the other rewards are meant to find sooner. Its indices are all 0,
    so that no ratio to them exists: compare by success, time and distance.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Zeros, (num_envs,)."""
        return carry, sample.distance.__array_namespace__().zeros_like(sample.distance)
