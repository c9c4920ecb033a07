"""The baseline reward with its two conditions as printed: NOTE eq. 21."""

from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class BaselineEq21:
    """The baseline reward with its two conditions as printed, which is the reverse of the code that was run.

        Dd < 0:   r = -Dd
        Dd >= 0:  r = Bd - Pb - Dd = Bd - d(t)

    with Dd = d(t) - Pb (eq. 15), where d(t) is the distance after step t (eq. 14), Pb is the smallest distance before
    the step (eq. 16, 17), and Bd = d(0) (eq. 22). Source: NOTE eq. 21; ARP eq. 20 has the same conditions. The value is
    in metres, so it is not scale-free; -d(t) <= r <= Bd.

    The contradiction: the listing in NOTE section VIII, which was run (reward `baseline`), pays Bd - d(t) for coming
    closer than before, and -Dd for staying farther away. As printed, coming closer pays only the distance gained in the
    step. An arm that stands still or turns back is paid Bd - d(t). That is above 0 as long as the target is nearer than
    at the start, so waiting next to the target pays the same again at every step. Both rewards agree where Dd = 0, and
    on a first step towards the target.

    Two more equations are printed and not used here. Eq. 23 says Pb = PrevBest(t), and in eq. 17 PrevBest(t) includes
    the distance of this step, so that Dd could never be below 0. Here Pb is the smallest distance before the step, as
    in the code. Eq. 24 gives the right side of eq. 21 as the value of Dd itself.

    For the NOTE's example 2, from sqrt(6.25) to sqrt(4.25), the first case pays sqrt(6.25) - sqrt(4.25) = 0.438.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        gained = sample.begin_distance - sample.distance
        return carry, xp.where(sample.delta_distance < 0.0, -sample.delta_distance, gained)
