"""``harness run``: train every combination, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from harness.cli.interrupted import kept_when_interrupted
from harness.cli.lines import complain, say
from harness.cli.options import (
    ALGORITHMS,
    REWARDS,
    SIMULATORS,
    TRACKERS,
    CurveKind,
    ExecutorName,
    MetricNames,
    Names,
    PluginFiles,
    RewardNames,
    RobotName,
    TaskName,
)
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.experiment.foresee import Foreseen
    from harness.results import Results


def run(
    experiment: Annotated[
        Path | None,
        typer.Argument(help="Experiment file (TOML). Its keys are named like the flags; a flag overrides its key."),
    ] = None,
    sim: Annotated[
        Names, typer.Option(help="Simulators to train in.", metavar="NAME,...", autocompletion=SIMULATORS)
    ] = None,
    algo: Annotated[
        Names,
        typer.Option(help="Algorithms, such as sac:learning_rate=1e-3.", metavar="NAME,...", autocompletion=ALGORITHMS),
    ] = None,
    reward: RewardNames = None,
    baseline: Annotated[
        str | None,
        typer.Option(
            help="The reward that the others are compared with.",
            show_default="baseline",
            metavar="NAME",
            autocompletion=REWARDS,
        ),
    ] = None,
    task: TaskName = None,
    robot: RobotName = None,
    seeds: Annotated[
        str | None, typer.Option(help="How many seeds, or a list of them (3,7,11).", show_default="6", metavar="N")
    ] = None,
    steps: Annotated[
        int | None, typer.Option(help="Environment steps of training per cell.", show_default="5000", metavar="N")
    ] = None,
    evaluation_episodes: Annotated[
        int | None, typer.Option(help="Episodes of each evaluation.", show_default="100", metavar="N")
    ] = None,
    evaluate_every: Annotated[
        int | None,
        typer.Option(
            help="Environment steps from one evaluation to the next.", show_default="only at the end", metavar="N"
        ),
    ] = None,
    deterministic: Annotated[
        bool | None,
        typer.Option(
            "--deterministic/--stochastic",
            help="Evaluate policies without randomness, or let them draw their actions at random.",
            show_default="deterministic",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="The experiment's folder.", show_default="one under results/runs/", metavar="DIR"),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="How many cells run at once.", show_default="as many as cores", metavar="N")
    ] = None,
    executor: ExecutorName = "processes",
    checkpoint_every: Annotated[
        int | None,
        typer.Option(
            help="Environment steps between checkpoints. A killed cell goes on from its last one. 0: no checkpoints.",
            show_default="every ten minutes",
            metavar="N",
        ),
    ] = None,
    tracker: Annotated[
        Names,
        typer.Option(
            help="Also send the learning curves to a tracker, such as wandb:mode=offline.",
            show_default="nowhere",
            metavar="NAME,...",
            autocompletion=TRACKERS,
        ),
    ] = None,
    tensorboard: Annotated[bool, typer.Option("--tensorboard", help="Short for --tracker tensorboard.")] = False,
    wandb: Annotated[bool, typer.Option("--wandb", help="Short for --tracker wandb.")] = False,
    mlflow: Annotated[bool, typer.Option("--mlflow", help="Short for --tracker mlflow.")] = False,
    curve: CurveKind = "accumulated",
    wait: Annotated[
        bool, typer.Option("--wait/--no-wait", help="If another run is using the folder: wait for it, or give up.")
    ] = True,
    changed: Annotated[
        Literal["refuse", "keep", "again"],
        typer.Option(
            help="If a plugin has changed since cells were done: refuse to run, keep these cells, or train them again."
        ),
    ] = "refuse",
    only: Annotated[
        str | None,
        typer.Option(
            help="Run only the cells that these words describe, such as sac,seed=3.",
            show_default="all",
            metavar="NAME,...",
        ),
    ] = None,
    limit: Annotated[
        int | None, typer.Option(help="Run at most this many cells.", show_default="all", metavar="N")
    ] = None,
    retry_failed: Annotated[
        int, typer.Option(help="How many times to try a failed cell again.", show_default="never", metavar="N")
    ] = 0,
    fail_fast: Annotated[bool, typer.Option("--fail-fast", help="Stop at the first cell that fails.")] = False,
    stall_after: Annotated[
        float,
        typer.Option(help="End a cell that makes no progress for this many seconds. 0: never.", metavar="SECONDS"),
    ] = 1800.0,
    cell_time: Annotated[
        float, typer.Option(help="The most seconds that a cell may take.", show_default="no limit", metavar="SECONDS")
    ] = 0.0,
    cell_memory: Annotated[
        float, typer.Option(help="The most memory that a cell may use, in GiB.", show_default="no limit", metavar="GIB")
    ] = 0.0,
    fresh: Annotated[bool, typer.Option("--fresh", help="Start a new process for every cell.")] = False,
    metric: MetricNames = None,
    plugin: PluginFiles = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress, only the results.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON on standard output.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would be run, and how long it would take. Writes nothing.")
    ] = False,
) -> int:
    """Train with every combination of reward, simulator, algorithm and seed, then compare the rewards.

    One such training is called a cell. A cell that is done is not run again: the same command goes on where it stopped.
    """
    from harness.cli.progress import LiveProgress
    from harness.cli.terminal import Terminal
    from harness.experiment.experiment import RunOptions, check, prepare
    from harness.experiment.foresee import foresee
    from harness.registry.given import read_given

    short = {"tensorboard": tensorboard, "wandb": wandb, "mlflow": mlflow}
    trackers = [*(tracker or ()), *(name for name, is_on in short.items() if is_on)]
    options = RunOptions(
        out, jobs, executor, checkpoint_every, trackers, curve, wait, changed, only, limit, retry_failed, fail_fast,
        stall_after, cell_time, cell_memory, fresh, metric,
    )  # fmt: skip
    given = {
        "sim": sim, "algo": algo, "reward": reward, "baseline": baseline, "task": task, "robot": robot,
        "seeds": _parse_seeds(seeds), "steps": steps, "evaluation_episodes": evaluation_episodes,
        "evaluate_every": evaluate_every, "deterministic": deterministic,
    }  # fmt: skip
    flags = {key: value for key, value in given.items() if value is not None}
    if experiment is None and not flags:
        raise UsageError(_what_to_type())
    asked, plugins = _read(experiment, flags), read_given(plugin)
    if dry_run:
        _show_foreseen(foresee(check(asked, options, plugins)), as_json)
        return 0
    ready = prepare(asked, options, plugins)
    folder = ready.store.folder
    console = Terminal(stderr=True, quiet=quiet)
    with (
        kept_when_interrupted("finished cells are kept", folder),
        ready.begin(lambda: complain(f"waiting for another run in '{folder}' to end")) as begun,
        LiveProgress((*begun.spared, *begun.waiting), begun.spared, console, ready.store.log_of) as progress,
    ):
        results = begun.run(progress, progress.warn)
    _show(results, as_json)
    if results.failed:
        complain(f"cells that failed: {len(results.failed)}. The same command tries them again, and no other")
    return 1 if results.failed else 0


def _what_to_type() -> str:
    """For who typed no more than ``harness run``."""
    from harness.cli.runnable import example_run, usable
    from harness.registry.registry import load_registry

    registry = load_registry()
    example = example_run(registry)
    if not example:
        return "nothing to run, and no simulator or no algorithm is installed: harness doctor says what is missing"
    return (
        f"what is to be run? Type: {example}; or harness run FILE.toml; or harness run --help. "
        f"Installed simulators: {', '.join(usable(registry, 'simulators'))}; "
        f"algorithms: {', '.join(usable(registry, 'algorithms'))}. New here: harness demo"
    )


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


def _show(results: "Results", as_json: bool) -> None:
    """The comparison on standard output; what was written too, unless JSON is to stand there alone."""
    from harness.cli.environments import show_environments
    from harness.cli.made import make_table_and_page
    from harness.cli.not_measured import complain_of_metrics
    from harness.cli.terminal import show
    from harness.report.document import report_text
    from harness.report.tables.overview import overview_table

    command = f"harness report {results.folder} --details{results.plugin_flags}"
    if results.is_in_environment:
        show_environments(results, command, as_json=as_json, html=None, details=False, summary=None)
    elif as_json:
        typer.echo(report_text(results))
    else:
        show(overview_table(results, command))
    complain_of_metrics(results)
    make_table_and_page(results, err=as_json)


def _show_foreseen(found: "Foreseen", as_json: bool) -> None:
    import json

    from harness.cli.foreseen import foreseen_lines

    if as_json:
        typer.echo(json.dumps(found.to_json(), indent=1))
        return
    for line in foreseen_lines(found):
        say(line)
