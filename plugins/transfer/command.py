"""``harness transfer``: policies trained in one simulator, evaluated in others."""

from typing import Annotated

import typer

from harness.cli.flags.shared import SIMULATORS, AsJson, ExperimentFolder, PluginFiles
from harness.cli.output import kept_when_interrupted, say, say_json


def transfer(
    folder: ExperimentFolder,
    to: Annotated[
        list[str] | None,
        typer.Option(
            help="Simulators to evaluate in, such as mujoco:substeps=40.",
            show_default="those of the experiment and all that are installed",
            metavar="NAME,...",
            autocompletion=SIMULATORS,
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="How many evaluations run at once.", show_default="as many as cores", metavar="N")
    ] = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Evaluate an experiment's policies in other simulators, and show how much of their success is left.

    Trains nothing. What is evaluated already is not evaluated again.
    """
    from harness import load_results
    from harness.experiment.workers.workers import worker_count
    from harness.registry import load_registry, read_given

    from .jobs import plan_transfers, run_transfers
    from .matrix import load_transfers
    from .progress import TransferProgress

    at_once, registry = worker_count(jobs), load_registry(given=read_given(plugin))
    results = load_results(folder, registry=registry)
    plan = plan_transfers(results, to, registry)
    with kept_when_interrupted("what was evaluated is kept", folder), TransferProgress(plan) as progress:
        run_transfers(plan, at_once, progress)
    transfers = load_transfers(results)
    if as_json:
        say_json(transfers.to_json())
    elif transfers.matrices:
        from harness.report.tables.grid import FactsTable, show

        from .shown import transfer_facts

        show(FactsTable(transfer_facts(transfers)))
    else:
        say("Nothing to evaluate: the policies were trained in the only simulator that is installed.")
    return 1 if transfers.failed else 0


transfer.examples = ("harness transfer my-results --to pybullet",)  # type: ignore[attr-defined] # harness shows them
