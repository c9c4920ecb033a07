"""Built-in commands that the core does without."""

import harness


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands, and the option of ``harness report`` that writes records."""
    register(
        "bench",
        "harness_plugins.bench.command:bench",
        summary="Show where the time of a training goes, or how fast plugins are compared with bare engines and "
        "libraries.",
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
        "report--summary",
        "harness_plugins.committed.records:records",
        summary="Write records: small tables and figures, made to be kept and shared.",
    )
    register(
        "video",
        "harness_plugins.video.command:video",
        summary="Make a film of recorded episodes: the arm, its target, what it is paid.",
    )
