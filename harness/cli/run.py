"""``harness run``: train every combination, compare, report."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, fields
from functools import partial
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
    FailOn,
    Jobs,
    Measures,
    MetricNames,
    Names,
    PluginFiles,
    RewardNames,
    RobotName,
    SimulatorNames,
    flag,
)
from harness.cli.help import HelpAll, takes
from harness.cli.output import complain, kept_when_interrupted, say, say_json
from harness.cli.status import so_far_of
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.cli.fail_on import Said
    from harness.experiment.experiment import ExperimentRun
    from harness.experiment.plan import Experiment
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import Given
    from harness.results import Results

PAGE = "run--watch"
"""The name, among commands, of the plugin that serves the page of ``harness run --watch``."""


@dataclass(frozen=True)
class RunFlags:
    """The flags of ``harness run``. Each has the name of the key of an experiment, or of the option, that it sets."""

    experiment: Annotated[
        Path | None,
        typer.Argument(
            help="An experiment file (TOML). Its keys are named like the flags, which override them.", metavar="FILE"
        ),
    ] = None
    sim: SimulatorNames = None
    algo: Annotated[Names, flag("NAME,...", "Algorithms, such as sac:learning_rate=1e-3.", offers=ALGORITHMS)] = None
    reward: RewardNames = None
    baseline: Annotated[
        str | None,
        flag("NAME", "The reward to compare with; none: train one reward alone.", "baseline", offers=REWARDS),
    ] = None
    task: Annotated[
        Names,
        flag("NAME,...", "Tasks or environments, such as fetch-reach.", "fd100-reach", name="--task", offers=TASKS),
    ] = None
    robot: RobotName = None
    seeds: Annotated[str | None, flag("N", "How many seeds, or a list: 3,7,11.", "6")] = None
    until: Annotated[
        Literal["decided"] | None, flag("decided", "Train in looks until the answer stands.", "all seeds at once")
    ] = None
    looks: Annotated[
        str | None,
        flag(
            "N,...",
            "With --until: the seeds of each reward in each place at each look.",
            "6,8,12,16,24,32; of four places and more 2,3,4,6,8,12,16",
        ),
    ] = None
    margin: Annotated[
        float | None,
        flag("SHARE", "With --until: a difference of success below this, as a share, ends the training.", "0.10"),
    ] = None
    steps: Annotated[int | None, flag("N", "Environment steps of each training.", "10000")] = None
    evaluation_episodes: EvaluationEpisodes = None
    evaluate_every: Annotated[
        int | None, flag("N", "Environment steps from one evaluation to the next.", "only at the end")
    ] = None
    deterministic: Annotated[
        bool | None,
        typer.Option(
            "--deterministic/--stochastic",
            help="Evaluate policies without randomness, or let them draw their actions at random.",
            show_default="deterministic",
        ),
    ] = None
    evaluation_horizon: Annotated[
        int | None, flag("N", "In an environment: steps after which an episode of an evaluation is cut.", "10000")
    ] = None
    out: Annotated[Path | None, flag("DIR", "The experiment's folder.", "one under results/runs/")] = None
    jobs: Jobs = None
    executor: ExecutorName = "processes"
    checkpoint_every: Annotated[
        int | None,
        flag(
            "N",
            "Environment steps between checkpoints. A killed cell goes on from its last one. 0: no checkpoints.",
            "every ten minutes",
        ),
    ] = None
    tracker: Annotated[
        Names,
        flag(
            "NAME,...",
            "Also send the learning curves to these: tensorboard, wandb:mode=offline.",
            "nowhere",
            offers=TRACKERS,
        ),
    ] = None
    curve: CurveKind = "accumulated"
    wait: Annotated[
        bool, typer.Option("--wait/--no-wait", help="If another run is using the folder: wait for it, or give up.")
    ] = True
    changed: Annotated[
        Literal["refuse", "keep", "again"],
        typer.Option(
            help="If a plugin has changed since cells were done: refuse to run, keep these cells, or train them again."
        ),
    ] = "refuse"
    only: Annotated[
        str | None, flag("NAME,...", "Run only the cells that these words describe, such as sac,seed=3.", "all")
    ] = None
    limit: Annotated[int | None, flag("N", "Run at most this many cells.", "all")] = None
    budget: Annotated[
        str | None,
        flag(
            "TIME",
            "Begin no cell after this time, such as 2h or 90m; the same command goes on later.",
            "no limit",
            name="--budget",
        ),
    ] = None
    retry_failed: Annotated[int, flag("N", "How many times to try a failed cell again.", "never")] = 0
    fail_fast: Annotated[bool, typer.Option("--fail-fast", help="Stop at the first cell that fails.")] = False
    stall_after: Annotated[
        float, flag("SECONDS", "End a cell that makes no progress for this many seconds. 0: never.")
    ] = 1800.0
    cell_time: Annotated[float, flag("SECONDS", "The most seconds that a cell may take.", "no limit")] = 0.0
    cell_memory: Annotated[float, flag("GIB", "The most memory that a cell may use, in GiB.", "no limit")] = 0.0
    fresh: Annotated[bool, typer.Option("--fresh", help="Start a new process for every cell.")] = False
    metrics: MetricNames = None
    measure: Measures = None
    fail_on: FailOn = None
    screen: Annotated[
        bool,
        typer.Option("--screen", help="First say what each reward pays for. It stops nothing."),
    ] = False
    plugin: PluginFiles = None
    watch: Annotated[
        bool, typer.Option("--watch", help="Show the trainings in the browser while they go on, as harness watch does.")
    ] = False
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress, only the results.")] = False
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON on standard output.")] = False
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would be run, and for how long. Writes nothing.")
    ] = False
    help_all: HelpAll = False


@takes(RunFlags)
def run(**given: Any) -> int:
    """Train with each reward, then compare what the robots do.

    It trains with every combination of reward, simulator, algorithm and seed. One such training is called a cell. A
    cell that is done is not run again: the same command goes on where it stopped.
    """
    from harness.experiment.experiment import check

    named = _named(given) if given["fail_on"] else ()
    (asked, options), plugins = read_flags(given), given_plugins(given)
    ready = check(asked, options, plugins)
    said = screen(ready) if given["screen"] else []
    if given["dry_run"]:
        results, status = None, foresee_run(ready, given["as_json"])
    else:
        results, status = train(ready, given["quiet"], given["watch"])
        show_run(results, given["as_json"])
    if not named:
        return status
    from harness.cli.fail_on import said_of, status_of

    return status_of(named, [*said, *(said_of(results) if results else [])], status)


def _named(given: Mapping[str, Any]) -> tuple[str, ...]:
    """The answers that ``--fail-on`` names.

    Raises:
        UsageError: There is no such answer, or nothing looks for it.
    """
    from harness.cli.fail_on import NAMES, named_answers

    named = named_answers(given["fail_on"], "behaviour", "pay")
    if unasked := [name for name in named if name in NAMES["pay"] and not given["screen"]]:
        raise UsageError(f"--fail-on {unasked[0]}: only --screen looks for that: add --screen, or leave it out")
    return named


def read_flags(given: Mapping[str, Any]) -> "tuple[Experiment, RunOptions]":
    """What is asked for, and how it is run.

    Args:
        given: What was given for each flag, by its name in `RunFlags`; flags that a command has not are missing.

    Raises:
        UsageError: Nothing is asked for, or a value is malformed.
    """
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import split_measures

    measures, _ = split_measures(given["measure"] or ())
    read = {
        **given,
        "tracker": given.get("tracker") or [],
        "measure": measures or None,
        "seeds": _parse_seeds(given.get("seeds")),
        "looks": _parse_looks(given["looks"]),
        "budget": parse_time(given["budget"]),
    }
    options = RunOptions(**{field.name: read[field.name] for field in fields(RunOptions) if field.name in read})
    return _read_asked(given["experiment"], read), options


def given_plugins(given: Mapping[str, Any]) -> "tuple[Given, ...]":
    """The files that were given with ``--plugin`` and ``--measure``."""
    from harness.registry.given import read_given, split_measures

    return read_given(given["plugin"], split_measures(given["measure"] or ())[1])


def _read_asked(path: Path | None, given: Mapping[str, Any]) -> "Experiment":
    """The experiment of a file, of flags, or of both.

    Raises:
        UsageError: There is none.
    """
    from harness.experiment.plan import Experiment, check_experiment, read_experiment

    keys = [field.name for field in fields(Experiment) if field.name != "plugins"]
    asked = {key: given[key] for key in keys if given.get(key) is not None}
    if path is not None:
        return read_experiment(path, asked)
    if not asked:
        raise UsageError(_what_to_type())
    return check_experiment(asked)


def screen(ready: "ExperimentRun") -> "list[Said]":
    """Say what screens find in the rewards that are to be trained."""
    from harness.cli.fail_on import Said
    from harness.experiment.screening import screened
    from harness.results.comparison import Group

    say("What the rewards pay for, before anything is trained:", err=True)
    found, said = screened(ready.plan.cells, ready.registry), list[Said]()
    several = len({(cell.robot, cell.task) for cell, _ in found.said}) > 1
    for cell, answer in found.said:
        labels = Group.of(cell).labels
        place = " · ".join(labels[kind] for kind in ("robot", "task") if kind in labels)
        said.append(Said("pay", f"{cell.reward.label} in {place}", answer.word))
        name = f"{cell.reward.label} in {place}" if several else cell.reward.label
        say(f"  {name}: {answer.word}. {answer.line}", err=True)
    for line in found.left_out:
        complain(line)
    return said


def foresee_run(ready: "ExperimentRun", as_json: bool) -> int:
    """Say what would be run."""
    from harness.cli.progress import foreseen_lines
    from harness.experiment.foresee import foresee

    found = foresee(ready, measures=True)
    for line in ready.plan.warnings:
        complain(line)
    if as_json:
        say_json(found.to_json())
        return 0
    for line in foreseen_lines(found):
        say(line)
    return 0


def train(ready: "ExperimentRun", quiet: bool, watch: bool = False) -> "tuple[Results, int]":
    """Run what is not done; what came of it, and status 1 where a cell failed."""
    from harness.cli.progress import LiveProgress
    from harness.record.store import Store
    from harness.report.tables.grid import Terminal

    folder = ready.store.folder
    Store.claim(folder)
    for line in ready.plan.warnings:
        complain(line)
    console = Terminal(stderr=True, quiet=quiet)
    with (
        kept_when_interrupted("finished cells are kept", folder),
        ready.begin(lambda: complain(f"waiting for another run in '{folder}' to end")) as begun,
        _page_of(folder) if watch else nullcontext(),
        LiveProgress(
            (*begun.spared, *begun.foreseen),
            begun.spared,
            console,
            ready.store.log_of,
            at_most=ready.plan.terms.has_plan,
            so_far=partial(so_far_of, store=ready.store),
        ) as progress,
    ):
        results = begun.run(progress, progress.warn)
    if results.failed:
        complain(f"cells that failed: {len(results.failed)}. The same command tries them again, and no other")
    return results, 1 if results.failed else 0


@contextmanager
def _page_of(folder: Path) -> Iterator[None]:
    """Serve the live page of a run as long as it goes on, and open it in the browser.

    Raises:
        UsageError: The plugin that serves it was left out.
    """
    import webbrowser

    from harness.registry.registry import load_registry

    served: Callable[[Path], AbstractContextManager[str]] = load_registry().get("commands", PAGE).load()
    with served(folder) as address:
        say(f"Live page: {address}", err=True)
        webbrowser.open(address)
        yield
    say(f"The live page ended with the run. Again: {command_text('harness', 'watch', folder)}", err=True)


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


def _parse_looks(text: str | None) -> list[int] | None:
    if text is None:
        return None
    try:
        return [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise UsageError(f"--looks {text}: give numbers of seeds that increase, such as 6,12,24") from None


UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}


def parse_time(text: str | None) -> float:
    """The seconds of ``--budget``; 0 for no limit."""
    if text is None:
        return 0.0
    short = text.strip().removesuffix("in")  # 10min are 10m
    number, unit = short[:-1], UNITS.get(short[-1:], 0.0)
    try:
        seconds = float(number) * unit
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e9:
        raise UsageError(f"--budget {text}: give a time, such as 90s, 30m, 2h or 1d")
    return seconds


def show_run(results: "Results", as_json: bool) -> None:
    """The comparison on standard output; what was written too, unless JSON is to stand there alone."""
    from harness.cli.output import make_table_and_page, show_results

    details = command_text("harness", "report", results.folder, "--details") + results.report_flags
    show_results(results, details, as_json=as_json)
    make_table_and_page(results, as_json)
