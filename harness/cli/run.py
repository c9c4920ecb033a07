"""``harness run``: train every combination, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.options import Names, RewardNames, RobotName, TaskName
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.experiment.plan import Plan
    from harness.record.store import Store
    from harness.registry.registry import Registry
    from harness.results import Results


def run(
    experiment: Annotated[
        Path | None, typer.Argument(help="Experiment file (TOML). Its keys are the flags below; a flag wins.")
    ] = None,
    sim: Annotated[Names, typer.Option(help="Simulators.", metavar="NAME,...")] = None,
    algo: Annotated[Names, typer.Option(help="Algorithms, as sac:learning_rate=1e-3.", metavar="NAME,...")] = None,
    reward: RewardNames = None,
    baseline: Annotated[
        str | None, typer.Option(help="What they are compared with.", show_default="baseline", metavar="NAME")
    ] = None,
    task: TaskName = None,
    robot: RobotName = None,
    seeds: Annotated[
        str | None, typer.Option(help="How many seeds, or a list (3,7,11).", show_default="3", metavar="N")
    ] = None,
    steps: Annotated[
        int | None, typer.Option(help="Environment steps of training per cell.", show_default="10000", metavar="N")
    ] = None,
    evaluation_episodes: Annotated[
        int | None, typer.Option(help="Episodes of an evaluation.", show_default="100", metavar="N")
    ] = None,
    evaluate_every: Annotated[
        int | None,
        typer.Option(help="Steps from one evaluation to the next.", show_default="at the end alone", metavar="N"),
    ] = None,
    deterministic: Annotated[
        bool | None,
        typer.Option(
            "--deterministic/--stochastic",
            help="Whether evaluated policies draw no actions.",
            show_default="they do not",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="The experiment's folder.", show_default="one under results/runs/", metavar="DIR"),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Cells at once.", show_default="as many as cores", metavar="N")
    ] = None,
    executor: Annotated[str, typer.Option(help="What runs the cells.", metavar="NAME")] = "processes",
    checkpoint_every: Annotated[
        int | None,
        typer.Option(help="Steps from one checkpoint to the next; killed, a cell goes on there.", metavar="N"),
    ] = None,
    tensorboard: Annotated[
        bool, typer.Option("--tensorboard", help="Leave event files of scalars in each cell's folder too.")
    ] = False,
) -> int:
    """Train every simulator x algorithm x reward x seed and compare the rewards.

    A cell that is done is not run again: the same command goes on where it stopped.
    """
    from harness.experiment.event_log import require_tensorboard
    from harness.experiment.experiment import default_folder
    from harness.experiment.plan import expand
    from harness.experiment.workers import core_count
    from harness.record.store import Store
    from harness.registry.registry import load_registry
    from harness.results import Results

    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs {jobs}: must be at least 1")
    if checkpoint_every is not None and checkpoint_every < 1:
        raise UsageError(f"--checkpoint-every {checkpoint_every}: must be at least 1")
    given = {
        "sim": sim, "algo": algo, "reward": reward, "baseline": baseline, "task": task, "robot": robot,
        "seeds": _parse_seeds(seeds), "steps": steps, "evaluation_episodes": evaluation_episodes,
        "evaluate_every": evaluate_every, "deterministic": deterministic,
    }  # fmt: skip
    if tensorboard:
        require_tensorboard()
    registry = load_registry()
    registry.get("executors", executor)
    plan = expand(_read(experiment, {key: value for key, value in given.items() if value is not None}), registry)
    store = Store.create(out or default_folder(plan), plan)
    try:
        _run_with_progress(plan, store, registry, jobs or core_count(), executor, checkpoint_every or 0, tensorboard)
    except KeyboardInterrupt:
        kept = f"harness: interrupted: finished cells are kept in '{store.folder}', the same command goes on from there"
        typer.echo(kept, err=True)
        raise
    results = Results(store.folder, registry)
    _show(results)
    return 1 if results.failed else 0


def _read(path: Path | None, flags: dict[str, Any]) -> Any:
    """The experiment of a file, of flags, or of both."""
    from harness.experiment.plan import check_experiment, read_experiment

    return check_experiment(flags) if path is None else read_experiment(path, flags)


def _parse_seeds(text: str | None) -> int | list[int] | None:
    if text is None:
        return None
    try:
        numbers = [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        numbers = []
    if not numbers:
        raise UsageError(f"--seeds {text}: give a number of seeds (3) or a list of seeds (3,7,11)")
    return numbers if "," in text else numbers[0]


def _run_with_progress(
    plan: "Plan",
    store: "Store",
    registry: "Registry",
    jobs: int,
    executor: str,
    checkpoint_every: int,
    tensorboard: bool,
) -> None:
    from harness.cli.progress import LiveProgress
    from harness.experiment.experiment import run_plan

    done = [cell for cell in plan.cells if store.is_done(cell)]
    with LiveProgress(plan.cells, done) as progress:
        run_plan(plan, store, registry, jobs, progress, executor, checkpoint_every, tensorboard)


def _show(results: "Results") -> None:
    from rich.console import Console

    from harness.record.store import REPORT
    from harness.report.comparison_table import comparison_table
    from harness.report.html import write_html

    console = Console(stderr=True)
    console.print(comparison_table(results))
    results.write_table()
    console.print(f"Results: {results.folder}", soft_wrap=True)
    try:
        write_html(results, results.folder / REPORT)
        console.print(f"Report:  {results.folder / REPORT}", soft_wrap=True)
    except UsageError as error:  # the extra is missing: the results are there all the same
        console.print(f"No {REPORT}: {error}", soft_wrap=True)
