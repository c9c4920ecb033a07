"""Built-in commands that the core does without."""

import harness


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands, what writes records, and what ``harness watch`` shows beside experiments."""
    register(
        "audit",
        "harness_plugins.audit.command:audit",
        summary="Say what rewards pay for. Trains nothing.",
        heading="Ask more",
    )
    register(
        "check",
        "harness_plugins.kit.inspection.command:check",
        summary="Check whether a plugin or robot keeps the rules of its kind. Each result is a sentence with numbers.",
        heading="For plugin authors",
    )
    register(
        "doctor",
        "harness_plugins.doctor.command:doctor",
        summary="Show what is installed, what is missing, and what works here. "
        "Simulators and environments take a step each.",
        heading="Run and read",
    )
    register(
        "export",
        "harness_plugins.exporters.command:export",
        summary="Write a policy as ONNX model, or trainings as CSV files.",
    )
    register(
        "new-plugin",
        "harness_plugins.kit.new_plugin:new_plugin",
        summary="Write a plugin's package: a working implementation, its tests, a README and a CI workflow.",
        heading="For plugin authors",
    )
    register(
        "parity",
        "harness_plugins.parity.command:parity",
        summary="Drive the same motions through several simulators and show how far they differ. Trains nothing.",
    )
    register(
        "watch",
        "harness_plugins.watch.command:watch",
        summary="Show trainings in the browser while they go on. With success and pay, what runs, answers and films so "
        "far.",
        heading="Run and read",
    )
    register(
        "run--watch",
        "harness_plugins.watch.watch:served",
        summary="Show the trainings of a run in the browser while they go on.",
    )
    register(
        "watch--certificates",
        "harness_plugins.audit.search.out:page_in",
        summary="Show the certificates of a search in the browser.",
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
        heading="Run and read",
    )
    register(
        "transfer",
        "harness_plugins.transfer.command:transfer",
        summary="Evaluate an experiment's policies in other simulators, and show how much of their success is left.",
        heading="Ask more",
    )


@harness.hookimpl
def register_screens(register: harness.Register) -> None:
    """Announce what these commands say of rewards before they train."""
    register(
        "cheats",
        "harness_plugins.audit.screen:Cheats",
        summary="What each reward pays a cheat: scripted movements of an arm, and a search in any environment.",
    )


@harness.hookimpl
def register_sections(register: harness.Register) -> None:
    """Announce what these commands add to a report."""
    register(
        "transfer",
        "harness_plugins.transfer.section:TransferSection",
        summary="What policies are worth in other simulators than the one that trained them.",
    )
