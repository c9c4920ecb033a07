"""Registers the reward. Light: it is imported by every `harness` command."""

import harness


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """Announce the reward."""
    register("cautious", "cautious_reward.reward:Cautious", summary="pays the distance gained in the step")
