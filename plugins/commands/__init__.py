"""Built-in commands that the core does without."""

import harness


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands."""
    register("audit", "harness_plugins.audit.command:audit", summary="Say what rewards pay for. Trains nothing.")
    register(
        "doctor",
        "harness_plugins.doctor.doctor:doctor",
        summary="Show what is installed, what is missing, and what works here. "
        "Simulators and environments take a step each.",
    )
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
        "watch",
        "harness_plugins.watch.watch:watch",
        summary="Show recorded episodes in the browser. While a run goes on, the page says when more cells have ended.",
    )
