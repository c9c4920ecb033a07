"""Built-in commands that need a library which the core does without."""

import harness


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands."""
    register(
        "export",
        "harness_plugins.commands.export:export",
        summary="Write a policy as ONNX or TorchScript model, or trainings as CSV files.",
    )
