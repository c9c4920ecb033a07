"""Built-in executors."""

import harness


@harness.hookimpl
def register_executors(register: harness.Register) -> None:
    """Announce the built-in executors."""
    register("processes", "harness_plugins.executors.processes:Processes", summary="a fresh process for every cell")
