"""Built-in algorithms."""

import harness


@harness.hookimpl
def register_algorithms(register: harness.Register) -> None:
    """Announce the built-in algorithms."""
    register(
        "sac",
        "harness_plugins.algorithms.sac:Sac",
        summary="soft actor-critic of stable-baselines3, on the CPU",
        requires=("stable_baselines3", "torch"),
        extra="sb3",
    )
