"""Built-in tasks."""

import harness


@harness.hookimpl
def register_tasks(register: harness.Register) -> None:
    """Announce the built-in tasks."""
    register(
        "arp-2021",
        "harness_plugins.tasks.unity:Arp2021",
        summary="the published experiment: fixed start and target, joint angles are set",
    )
    register("fd100-reach", "harness.reach:ReachTask", summary="bring the FD100's end effector to a target in a box")
    register(
        "unity-reach",
        "harness_plugins.tasks.unity:UnityReach",
        summary="the baseline's Unity task: random start and target, joint angles are set",
    )
