"""Registers the algorithm. Keep it light: every `harness` command imports it."""

import harness

harness_api = 2


@harness.hookimpl
def register_algorithms(register: harness.Register) -> None:
    """Announce the algorithm; manifests record the versions of what it requires."""
    register(
        "sbx-sac",
        "sbx_sac.algorithm:SbxSac",
        summary="soft actor-critic by sbx: stable-baselines3 on JAX",
        requires=["sbx", "stable_baselines3", "jax"],
    )
