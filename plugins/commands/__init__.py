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
