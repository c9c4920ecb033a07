"""Built-in tasks."""

import harness


@harness.hookimpl
def register_tasks(register: harness.Register) -> None:
    """Announce the built-in tasks."""
    register("fd100-reach", "harness.task:ReachTask", summary="bring the FD100's end effector to a target in a box")
