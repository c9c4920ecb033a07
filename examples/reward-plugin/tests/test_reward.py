"""The reward keeps its contract."""

from cautious_reward.reward import Cautious

from harness_plugins.kit import check_contract


def test_contract() -> None:
    """It is finite, pure, the same in any batch, and works with arrays of any library."""
    check_contract("reward", Cautious())
