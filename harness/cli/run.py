"""``harness run``: train every combination, compare, report."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cli.flags import run as flags
from harness.cli.flags.shared import (
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
from harness.cli.interrupted import kept_when_interrupted
from harness.cli.lines import complain, say, say_json
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.experiment.experiment import RunOptions
    from harness.experiment.plan import Experiment
    from harness.registry.given import Given
    from harness.results import Results


def run(
    experiment: flags.ExperimentFile = None,
    sim: SimulatorNames = None,
    algo: flags.AlgorithmNames = None,
    reward: RewardNames = None,
    baseline: flags.Baseline = None,
    task: flags.TaskNames = None,
    robot: RobotName = None,
    seeds: flags.Seeds = None,
    steps: flags.Steps = None,
    evaluation_episodes: EvaluationEpisodes = None,
    evaluate_every: flags.EvaluateEvery = None,
    deterministic: flags.Deterministic = None,
    evaluation_horizon: flags.EvaluationHorizon = None,
    out: flags.OutFolder = None,
    jobs: Jobs = None,
    executor: ExecutorName = "processes",
    checkpoint_every: flags.CheckpointEvery = None,
    tracker: flags.TrackerNames = None,
    tensorboard: flags.Tensorboard = False,
    wandb: flags.Wandb = False,
    mlflow: flags.Mlflow = False,
    curve: CurveKind = "accumulated",
    wait: flags.Wait = True,
    changed: flags.Changed = "refuse",
    only: flags.Only = None,
    limit: flags.Limit = None,
    retry_failed: flags.RetryFailed = 0,
    fail_fast: flags.FailFast = False,
    stall_after: flags.StallAfter = 1800.0,
    cell_time: flags.CellTime = 0.0,
    cell_memory: flags.CellMemory = 0.0,
    fresh: flags.Fresh = False,
    metric: MetricNames = None,
    measure: Measures = None,
    plugin: PluginFiles = None,
    quiet: flags.Quiet = False,
    as_json: flags.AsJson = False,
    dry_run: flags.DryRun = False,
) -> int:
    """Train with every combination of reward, simulator, algorithm and seed, then compare the rewards.

    One such training is called a cell. A cell that is done is not run again: the same command goes on where it stopped.
    """
    from harness.experiment.experiment import RunOptions
    from harness.registry.given import read_given, split_measures

    measures, files = split_measures(measure or ())
    trackers = _all_trackers(tracker, {"tensorboard": tensorboard, "wandb": wandb, "mlflow": mlflow})
    options = RunOptions(
        out, jobs, executor, checkpoint_every, trackers, curve, wait, changed, only, limit, retry_failed, fail_fast,
        stall_after, cell_time, cell_memory, fresh, metric,
    )  # fmt: skip
    asked = _read(
        experiment,
        {
            "sim": sim, "algo": algo, "reward": reward, "baseline": baseline, "task": task, "robot": robot,
            "seeds": _parse_seeds(seeds), "steps": steps, "evaluation_episodes": evaluation_episodes,
            "evaluate_every": evaluate_every, "deterministic": deterministic, "measure": measures or None,
            "evaluation_horizon": evaluation_horizon,
        },
    )  # fmt: skip
    plugins = read_given(plugin, files)
    if dry_run:
        return _foresee(asked, options, plugins, as_json)
    return _train(asked, options, plugins, quiet, as_json)


def _read(path: Path | None, given: Mapping[str, Any]) -> "Experiment":
    """The experiment of a file, of flags, or of both.

    Raises:
        UsageError: There is none.
    """
    from harness.experiment.plan import check_experiment, read_experiment

    told = {key: value for key, value in given.items() if value is not None}
    if path is not None:
        return read_experiment(path, told)
    if not told:
        raise UsageError(_what_to_type())
    return check_experiment(told)


def _all_trackers(named: Names, short: Mapping[str, bool]) -> list[str]:
    """Those that are named, and those whose short flag is given."""
    return [*(named or ()), *(name for name, is_on in short.items() if is_on)]


def _foresee(asked: "Experiment", options: "RunOptions", plugins: "Sequence[Given]", as_json: bool) -> int:
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


def _train(asked: "Experiment", options: "RunOptions", plugins: "Sequence[Given]", quiet: bool, as_json: bool) -> int:
    """Run what is not done, and show what came of it; status 1 where a cell failed."""
    from harness.cli.progress import LiveProgress
    from harness.cli.terminal import Terminal
    from harness.experiment.experiment import prepare

    ready = prepare(asked, options, plugins)
    for line in ready.plan.warnings:
        complain(line)
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
    from harness.cli.made import make_table_and_page
    from harness.cli.results_shown import show_results

    show_results(results, f"harness report {results.folder} --details{results.report_flags}", as_json=as_json)
    make_table_and_page(results, as_json)
