"""The baseline reward, Type I: NOTE section VIII, as the code that was run has it."""

from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Baseline:
    """Pays the distance gained since the episode's start whenever the best so far is met or beaten.

        Dd > 0:   r = -Dd
        Dd <= 0:  r = Bd - d(t)

    with Dd = d(t) - Pb, Pb the smallest distance before the step and Bd = d(0). Source: the code listing in NOTE
    section VIII (UNITY, RobotControllerAgent.cs). NOTE eq. 21 prints the two conditions the other way round; the code
    is what was run. In metres, hence not scale-free.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        gained = sample.begin_distance - sample.distance
        return carry, xp.where(sample.delta_distance > 0.0, -sample.delta_distance, gained)
