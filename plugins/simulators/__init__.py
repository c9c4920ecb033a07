"""Built-in simulators."""

import harness


@harness.hookimpl
def register_simulators(register: harness.Register) -> None:
    """Announce the built-in simulators."""
    register(
        "mujoco",
        "harness_plugins.simulators.mujoco:Mujoco",
        summary="MuJoCo, many arms through mujoco.rollout threads",
        requires=("mujoco",),
        extra="mujoco",
    )
