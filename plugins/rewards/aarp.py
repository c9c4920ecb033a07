"""AARP, the accelerated-and-accelerated reward policy: this project's definition."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Pay, Sample

from ..factors import Factor


@dataclass(frozen=True)
class Aarp:
    """Pays like `arp`, with a gain that grows with every improvement in a row.

        n(t) = n(t-1) + 1 where Dd < 0, else 0                steps in a row that beat the best, n(0) = 0
        K(t) = min(k2 growth^n(t), k_max)
        Dd > 0:   r = -k1 Dd
        Dd <= 0:  r = K(t) (Bd - d(t))

    with Dd = d(t) - Pb, where d(t) is the distance after step t, Pb is the smallest distance before the step, and
    Bd = d(0). With growth = 1 this is `arp`. The reward remembers the gain: K(t) = min(growth K(t-1), k_max) where
    Dd < 0, else k2.

    This project's own definition fills a gap: NOTE section XII, "accelerated-and-accelerated reward policy (AARP)", is
    a heading without text. ARP multiplies the baseline by a gain. Here that gain grows with consecutive improvement.

    The value is in metres, so it is not scale-free. It is bounded as long as the workspace is:
    -k1 d(t) <= r <= k_max Bd. As under the baseline, an approach of many small steps is paid more than one of few large
    steps. Here the growing gain makes this up to k_max / k2 times as much.
    """

    k1: Annotated[
        Factor,
        Field(description="factor on the penalty for being farther than the best distance, K1 of arp"),
    ] = 1.0
    k2: Annotated[
        Factor,
        Field(description="smallest gain on the pay for matching or beating the best distance, K2 of arp"),
    ] = 1.5
    growth: Annotated[Pay, Field(ge=1, description="factor on the gain for each improvement in a row")] = 1.1
    k_max: Annotated[Factor, Field(description="largest gain, at least k2")] = 3.0

    def __post_init__(self) -> None:
        if self.k_max < self.k2:
            raise ValueError(f"k_max={self.k_max:g} should be at least k2={self.k2:g}")

    def initial_carry(self, begin_distance: Array) -> Carry:
        """The gain K, (num_envs,), k2 at first."""
        return begin_distance.__array_namespace__().full_like(begin_distance, self.k2)

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), [m]."""
        xp = sample.distance.__array_namespace__()
        grown = self.growth * carry
        capped = xp.where(grown < self.k_max, grown, self.k_max)
        gain = xp.where(sample.delta_distance < 0.0, capped, self.k2)
        gained = sample.begin_distance - sample.distance
        return gain, xp.where(sample.delta_distance > 0.0, -self.k1 * sample.delta_distance, gain * gained)
