"""``harness run``: train every combination, compare, report."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from harness.cli.flags.shared import (
    ALGORITHMS,
    REWARDS,
    TASKS,
    TRACKERS,
    CurveKind,
    EvaluationEpisodes,
    ExecutorName,
    Jobs,
    Measures,
    MetricNames,
    Names,
    PluginFiles,
    RewardNames,
    RobotName,
    SimulatorNames,
)
from harness.cli.help import HelpAll
from harness.cli.interrupted import kept_when_interrupted
from harness.cli.output import complain, say, say_json
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.experiment.plan import Experiment
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import Given
    from harness.results import Results


ExperimentFile = Annotated[
    Path | None,
    typer.Argument(
        help="An experiment file (TOML). Its keys are named like the flags, which override them.", metavar="FILE"
    ),
]
TaskNames = Annotated[
    Names,
    typer.Option(
        "--task",
        help="Tasks or environments, such as fetch-reach.",
        show_default="fd100-reach",
        metavar="NAME,...",
        autocompletion=TASKS,
    ),
]
AlgorithmNames = Annotated[
    Names,
    typer.Option(help="Algorithms, such as sac:learning_rate=1e-3.", metavar="NAME,...", autocompletion=ALGORITHMS),
]
Baseline = Annotated[
    str | None,
    typer.Option(
        help="The reward to compare with; none: train one reward alone.",
        show_default="baseline",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Seeds = Annotated[str | None, typer.Option(help="How many seeds, or a list: 3,7,11.", show_default="6", metavar="N")]
Until = Annotated[
    Literal["decided"] | None,
    typer.Option(help="Train in looks until the answer stands.", show_default="all seeds at once", metavar="decided"),
]
Looks = Annotated[
    str | None,
    typer.Option(
        help="With --until: the seeds of each reward in each place at each look.",
        show_default="6,8,12,16,24,32; of four places and more 2,3,4,6,8,12,16",
        metavar="N,...",
    ),
]
Margin = Annotated[
    float | None,
    typer.Option(
        help="With --until: a difference of success below this, as a share, ends the training.",
        show_default="0.10",
        metavar="SHARE",
    ),
]
BudgetTime = Annotated[
    str | None,
    typer.Option(
        "--budget",
        help="Begin no cell after this time, such as 2h or 90m; the same command goes on later.",
        show_default="no limit",
        metavar="TIME",
    ),
]
Steps = Annotated[
    int | None, typer.Option(help="Environment steps of each training.", show_default="5000", metavar="N")
]
EvaluateEvery = Annotated[
    int | None,
    typer.Option(
        help="Environment steps from one evaluation to the next.", show_default="only at the end", metavar="N"
    ),
]
Deterministic = Annotated[
    bool | None,
    typer.Option(
        "--deterministic/--stochastic",
        help="Evaluate policies without randomness, or let them draw their actions at random.",
        show_default="deterministic",
    ),
]
EvaluationHorizon = Annotated[
    int | None,
    typer.Option(
        help="In an environment: steps after which an episode of an evaluation is cut.",
        show_default="10000",
        metavar="N",
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(help="The experiment's folder.", show_default="one under results/runs/", metavar="DIR"),
]
CheckpointEvery = Annotated[
    int | None,
    typer.Option(
        help="Environment steps between checkpoints. A killed cell goes on from its last one. 0: no checkpoints.",
        show_default="every ten minutes",
        metavar="N",
    ),
]
TrackerNames = Annotated[
    Names,
    typer.Option(
        help="Also send the learning curves to these: tensorboard, mlflow, wandb:mode=offline.",
        show_default="nowhere",
        metavar="NAME,...",
        autocompletion=TRACKERS,
    ),
]
Wait = Annotated[
    bool, typer.Option("--wait/--no-wait", help="If another run is using the folder: wait for it, or give up.")
]
Changed = Annotated[
    Literal["refuse", "keep", "again"],
    typer.Option(
        help="If a plugin has changed since cells were done: refuse to run, keep these cells, or train them again."
    ),
]
Only = Annotated[
    str | None,
    typer.Option(
        help="Run only the cells that these words describe, such as sac,seed=3.", show_default="all", metavar="NAME,..."
    ),
]
Limit = Annotated[int | None, typer.Option(help="Run at most this many cells.", show_default="all", metavar="N")]
RetryFailed = Annotated[
    int, typer.Option(help="How many times to try a failed cell again.", show_default="never", metavar="N")
]
FailFast = Annotated[bool, typer.Option("--fail-fast", help="Stop at the first cell that fails.")]
StallAfter = Annotated[
    float, typer.Option(help="End a cell that makes no progress for this many seconds. 0: never.", metavar="SECONDS")
]
CellTime = Annotated[
    float, typer.Option(help="The most seconds that a cell may take.", show_default="no limit", metavar="SECONDS")
]
CellMemory = Annotated[
    float, typer.Option(help="The most memory that a cell may use, in GiB.", show_default="no limit", metavar="GIB")
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Start a new process for every cell.")]
Screen = Annotated[
    bool,
    typer.Option("--screen", help="First say which rewards pay for not finishing, by scripted movements of the arm."),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Show no progress, only the results.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the results as JSON on standard output.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Say what would be run, and for how long. Writes nothing.")]


def run(
    experiment: ExperimentFile = None,
    sim: SimulatorNames = None,
    algo: AlgorithmNames = None,
    reward: RewardNames = None,
    baseline: Baseline = None,
    task: TaskNames = None,
    robot: RobotName = None,
    seeds: Seeds = None,
    until: Until = None,
    looks: Looks = None,
    margin: Margin = None,
    steps: Steps = None,
    evaluation_episodes: EvaluationEpisodes = None,
    evaluate_every: EvaluateEvery = None,
    deterministic: Deterministic = None,
    evaluation_horizon: EvaluationHorizon = None,
    out: OutFolder = None,
    jobs: Jobs = None,
    executor: ExecutorName = "processes",
    checkpoint_every: CheckpointEvery = None,
    tracker: TrackerNames = None,
    curve: CurveKind = "accumulated",
    wait: Wait = True,
    changed: Changed = "refuse",
    only: Only = None,
    limit: Limit = None,
    budget: BudgetTime = None,
    retry_failed: RetryFailed = 0,
    fail_fast: FailFast = False,
    stall_after: StallAfter = 1800.0,
    cell_time: CellTime = 0.0,
    cell_memory: CellMemory = 0.0,
    fresh: Fresh = False,
    metric: MetricNames = None,
    measure: Measures = None,
    plugin: PluginFiles = None,
    quiet: Quiet = False,
    as_json: AsJson = False,
    dry_run: DryRun = False,
    help_all: HelpAll = False,
) -> int:
    """Train with each reward, then compare what the robots do.

    It trains with every combination of reward, simulator, algorithm and seed. One such training is called a cell. A
    cell that is done is not run again: the same command goes on where it stopped.
    """
    given = locals()  # every flag by its name, which is that of the option or of the key that it sets
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import read_given, split_measures

    measures, files = split_measures(measure or ())
    given |= {
        "tracker": tracker or [],
        "metrics": metric,
        "measure": measures or None,
        "seeds": _parse_seeds(seeds),
    }
    given |= {"looks": None if looks is None else parse_looks(looks), "budget": parse_time(budget)}
    options = RunOptions(**{field.name: given[field.name] for field in fields(RunOptions)})
    asked, plugins = read_asked(experiment, given), read_given(plugin, files)
    if dry_run:
        return foresee_run(asked, options, plugins, as_json)
    results, status = train(asked, options, plugins, quiet)
    show_run(results, as_json)
    return status


def read_asked(path: Path | None, given: Mapping[str, Any]) -> "Experiment":
    """The experiment of a file, of flags, or of both.

    Raises:
        UsageError: There is none.
    """
    from harness.experiment.plan import Experiment, check_experiment, read_experiment

    keys = [field.name for field in fields(Experiment) if field.name != "plugins"]
    told = {key: given[key] for key in keys if given[key] is not None}
    if path is not None:
        return read_experiment(path, told)
    if not told:
        raise UsageError(_what_to_type())
    return check_experiment(told)


def foresee_run(asked: "Experiment", options: "RunOptions", plugins: "Sequence[Given]", as_json: bool) -> int:
    """Say what would be run."""
    from harness.cli.foreseen import foreseen_lines
    from harness.experiment.experiment import check
    from harness.experiment.foresee import foresee

    ready = check(asked, options, plugins)
    found = foresee(ready)
    for line in ready.plan.warnings:
        complain(line)
    if as_json:
        say_json(found.to_json())
        return 0
    for line in foreseen_lines(found):
        say(line)
    return 0


def train(asked: "Experiment", options: "RunOptions", plugins: "Sequence[Given]", quiet: bool) -> "tuple[Results, int]":
    """Run what is not done; what came of it, and status 1 where a cell failed."""
    from harness.cli.progress import LiveProgress
    from harness.cli.terminal import Terminal
    from harness.experiment.experiment import check
    from harness.record.store import Store

    ready = check(asked, options, plugins)
    folder = ready.store.folder
    Store.claim(folder)
    for line in ready.plan.warnings:
        complain(line)
    console = Terminal(stderr=True, quiet=quiet)
    with (
        kept_when_interrupted("finished cells are kept", folder),
        ready.begin(lambda: complain(f"waiting for another run in '{folder}' to end")) as begun,
        LiveProgress((*begun.spared, *begun.waiting), begun.spared, console, ready.store.log_of) as progress,
    ):
        results = begun.run(progress, progress.warn)
    if results.failed:
        complain(f"cells that failed: {len(results.failed)}. The same command tries them again, and no other")
    return results, 1 if results.failed else 0


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


def parse_looks(text: str) -> list[int]:
    """The numbers of seeds of ``--looks``.

    Raises:
        UsageError: They are no numbers.
    """
    try:
        return [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise UsageError(f"--looks {text}: give numbers of seeds that increase, such as 6,12,24") from None


UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}


def parse_time(text: str | None) -> float:
    """The seconds of ``--budget``; 0 for no limit.

    Raises:
        UsageError: It is no time.
    """
    if text is None:
        return 0.0
    number, unit = text.strip()[:-1], UNITS.get(text.strip()[-1:], 0.0)
    try:
        seconds = float(number) * unit
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e9:
        raise UsageError(f"--budget {text}: give a time, such as 90s, 30m, 2h or 1d")
    return seconds


def show_run(results: "Results", as_json: bool) -> None:
    """The comparison on standard output; what was written too, unless JSON is to stand there alone."""
    from harness.cli.results_shown import show_results
    from harness.cli.table_and_page import make_table_and_page

    details = command_text("harness", "report", results.folder, "--details") + results.report_flags
    show_results(results, details, as_json=as_json)
    make_table_and_page(results, as_json)
