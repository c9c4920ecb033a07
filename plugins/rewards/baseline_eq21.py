"""The baseline reward with its two conditions as printed: NOTE eq. 21."""

from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class BaselineEq21:
    """The baseline reward with its two conditions as printed, the reverse of the code that was run.

        Dd < 0:   r = -Dd
        Dd >= 0:  r = Bd - Pb - Dd = Bd - d(t)

    with Dd = d(t) - Pb (eq. 15), Pb the smallest distance before the step (eq. 16, 17) and Bd = d(0) (eq. 22). Source:
    NOTE eq. 21; ARP eq. 20 has the same conditions. In metres, hence not scale-free; -d(t) <= r <= Bd.

    The contradiction: the listing in NOTE section VIII, which was run (reward `baseline`), pays Bd - d(t) for coming
    closer and -Dd for missing the best. As printed, coming closer pays the step gained alone, and whoever stands still
    or turns back is paid Bd - d(t), above 0 as long as the target is nearer than at the start: waiting next to the
    target pays as much again at every step. The two agree where Dd = 0, and on a first step towards the target.

    Also printed, and not used: eq. 23 says Pb = PrevBest(t), and eq. 17 makes PrevBest(t) the smallest distance with
    this step's; then Dd could never be below 0. As in the code, Pb is the best before the step. Eq. 24 gives the right
    side of eq. 21 as the value of Dd itself.

    The NOTE's example 2, from sqrt(6.25) to sqrt(4.25), is paid sqrt(6.25) - sqrt(4.25) = 0.438 by the first case.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        gained = sample.begin_distance - sample.distance
        return carry, xp.where(sample.delta_distance < 0.0, -sample.delta_distance, gained)
