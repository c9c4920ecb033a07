"""Built-in commands that the core does without."""

import harness


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands."""
    register(
        "export",
        "harness_plugins.commands.export:export",
        summary="Write a policy as ONNX or TorchScript model, or trainings as CSV files.",
    )
    register(
        "parity",
        "harness_plugins.commands.parity:parity",
        summary="Drive the same motions through several simulators and show how far they differ. Trains nothing.",
    )
    register(
        "transfer",
        "harness_plugins.commands.transfer:transfer",
        summary="Evaluate an experiment's policies in other simulators, and show how much of their success is left.",
    )
    register(
        "tune",
        "harness_plugins.commands.tune:tune",
        summary="Search the hyperparameters of one algorithm, with an equal budget for every reward.",
    )


@harness.hookimpl
def register_sections(register: harness.Register) -> None:
    """Announce what these commands add to a report."""
    register(
        "transfer",
        "harness_plugins.transfer.section:TransferSection",
        summary="What policies are worth in other simulators than the one that trained them.",
    )
