"""Built-in rewards."""

import harness


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """Announce the built-in rewards."""
    register(
        "arp", "harness_plugins.rewards.arp:Arp", summary="accelerated reward policy, 'K2': baseline with two gains"
    )
    register("baseline", "harness_plugins.rewards.baseline:Baseline", summary="Type I, the Unity project's reward")
