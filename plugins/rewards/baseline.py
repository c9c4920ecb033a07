"""The baseline reward, Type I, as in the code that was run: NOTE section VIII."""

from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Baseline:
    """Pays the distance gained since the episode's start when the smallest distance so far is met or beaten.

        Dd > 0:   r = -Dd
        Dd <= 0:  r = Bd - d(t)

    with Dd = d(t) - Pb, where d(t) is the distance after step t, Pb is the smallest distance before the step, and
    Bd = d(0). Source: the code listing in NOTE section VIII (UNITY, RobotControllerAgent.cs). NOTE eq. 21 prints the
    two conditions the other way round. This reward follows the code, because the code was run. The value is in metres,
    so it is not scale-free; -d(t) <= r <= Bd.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        gained = sample.begin_distance - sample.distance
        return carry, xp.where(sample.delta_distance > 0.0, -sample.delta_distance, gained)
