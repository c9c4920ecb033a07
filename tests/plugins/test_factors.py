"""The factor that several rewards have."""

from harness.registry.choice import choose
from tests.refusals import refused
from tests.registered import REGISTRY

FACTORS = ("arp:k1", "arp:k2", "aarp:k1", "aarp:k2", "aarp:k_max", "aarp:growth", "adaptive:k_far", "adaptive:k_near")


def test_no_factor_makes_a_reward_infinite(subtests):
    """One that did would make sums of it infinite too."""
    for name in [*FACTORS, "dense:scale", "potential:scale", "scaled:factor", "shifted:offset"]:
        with subtests.test(name=name), refused("1000000000000000000"):
            choose(REGISTRY, "rewards", f"{name}=1e308").build(REGISTRY, "rewards")
