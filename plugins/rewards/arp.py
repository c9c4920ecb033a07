"""The accelerated reward policy, ARP, called K2: ARP section IV and its code."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample

from ..factors import Factor


@dataclass(frozen=True)
class Arp:
    """The baseline reward with a gain on each of its halves.

        Dd > 0:   r = -k1 Dd
        Dd <= 0:  r = k2 (Bd - Pb - Dd) = k2 (Bd - d(t))

    with Dd = d(t) - Pb, where d(t) is the distance after step t, Pb is the smallest distance before the step, and
    Bd = d(0). With k1 = k2 = 1 this is the baseline. Source: ARP section IV and its code. The NOTE only names this
    reward (section X, "accelerated reward functions") and gives no formula. The value is in metres, so it is not
    scale-free; -k1 d(t) <= r <= k2 Bd.

    Two settings are published, and they differ. ARP's text says k1 = 1, k2 = 2 (and that k2 = 1.1 showed nothing). The
    data behind its table and the published controller have k2 = 1.5, which is the default here. ARP eq. 20 prints the
    two conditions the other way round, like NOTE eq. 21 (reward `baseline-eq21`). This reward follows the code, because
    the code was run.

    k2 multiplies what is paid, so a policy that behaves exactly as before gets a larger I_P, the index of gains.
    """

    k1: Annotated[
        Factor,
        Field(description="factor on the penalty for being farther than the best distance so far, K1"),
    ] = 1.0
    k2: Annotated[
        Factor,
        Field(description="factor on the pay for matching or beating the best distance so far, K2"),
    ] = 1.5

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        gained = sample.begin_distance - sample.distance
        return carry, xp.where(sample.delta_distance > 0.0, -self.k1 * sample.delta_distance, self.k2 * gained)
