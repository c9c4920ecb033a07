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
    worse = "harness_plugins.tasks.worse"
    register("noisy-reach", f"{worse}:NoisyReach", summary="fd100-reach with noise on what is seen and done")
    register("delayed-reach", f"{worse}:DelayedReach", summary="fd100-reach seen 0.1 s late and done 0.1 s late")
    register("cluttered-reach", f"{worse}:ClutteredReach", summary="fd100-reach around obstacles: touching one ends it")
    register("varied-reach", f"{worse}:VariedReach", summary="fd100-reach with another arm in every episode")
    here = "harness_plugins.tasks"
    register("fd100-low", f"{here}.low:Low", summary="targets just above the ground: punishes careless paths")
    register("fd100-moving", f"{here}.moving:Moving", summary="follow a moving target: punishes hurry without control")
    register("fd100-pose", f"{here}.pose:Pose", summary="reach a target in its orientation: more than position counts")
    register(
        "fd100-small-target", f"{here}.small_target:SmallTarget", summary="within 1 cm: the last centimetres count"
    )
    register(
        "unity-reach",
        "harness_plugins.tasks.unity:UnityReach",
        summary="the baseline's Unity task: random start and target, joint angles are set",
    )
