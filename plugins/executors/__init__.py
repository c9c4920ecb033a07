"""Built-in executors."""

import harness


@harness.hookimpl
def register_executors(register: harness.Register) -> None:
    """Announce the built-in executors."""
    register(
        "processes",
        "harness_plugins.executors.processes:Processes",
        summary="processes of this machine",
    )
    register(
        "ray",
        "harness_plugins.executors.ray:Ray",
        summary="the nodes of a Ray cluster",
        requires=("ray",),
        extra="ray",
    )
    register(
        "slurm",
        "harness_plugins.executors.slurm:Slurm",
        summary="an array of Slurm jobs",
        requires=("submitit",),
        extra="slurm",
    )
