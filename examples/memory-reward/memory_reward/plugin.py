"""Registers the reward. Keep it light: every `harness` command imports it."""

import harness

harness_api = 2


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """Announce the reward."""
    register("steady", "memory_reward.reward:Steady", summary="pays progress, less where it comes in jerks")
