"""Registers one plugin of each kind that version 0.1.0 had, but for an executor."""

import harness

harness_api = 1


@harness.hookimpl
def register_simulators(register: harness.Register) -> None:
    """An arm that goes where it is told."""
    register("wary-sim", "wary_arm.simulator:Still", summary="goes where it is told")


@harness.hookimpl
def register_algorithms(register: harness.Register) -> None:
    """It does not learn."""
    register("wary-algo", "wary_arm.algorithm:Careful", summary="acts at random")


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """A reward of its own, and one that builds on another."""
    register("wary", "wary_arm.reward:Wary", summary="pays the distance gained in the step")
    register("wary-half", "wary_arm.reward:Half", summary="half of another reward")


@harness.hookimpl
def register_metrics(register: harness.Register) -> None:
    """A metric."""
    register("wary-way", "wary_arm.metric:Way", summary="length of the way")


@harness.hookimpl
def register_tasks(register: harness.Register) -> None:
    """A task."""
    register("wary-reach", "wary_arm.task:WaryReach", summary="targets on a line")


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """A command."""
    register("wary-reaches", "wary_arm.command:reaches", summary="how far an arm reaches")
