"""``harness choose``: the best of several rewards, with few trainings."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli import run as flags
from harness.cli.flags.shared import (
    REWARDS,
    EvaluationEpisodes,
    ExecutorName,
    Jobs,
    Measures,
    Names,
    PluginFiles,
    RobotName,
    SimulatorNames,
)
from harness.cli.help import HelpAll
from harness.cli.output import say
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.experiment.plan import Experiment
    from harness.registry.given import Given
    from harness.registry.registry import Registry
    from harness.results import Results

Candidates = Annotated[
    Names,
    typer.Option(
        help="The candidates, such as arp,dense,relative.",
        show_default="the rewards of the files",
        metavar="NAME,...",
        autocompletion=REWARDS,
    ),
]
Looks = Annotated[
    str | None,
    typer.Option(
        help="The seeds of each reward in each place at each look.",
        show_default="4,6,8,12,16,24,32",
        metavar="N,...",
    ),
]


def choose(
    experiment: flags.ExperimentFile = None,
    sim: SimulatorNames = None,
    algo: flags.AlgorithmNames = None,
    reward: Candidates = None,
    baseline: flags.Baseline = None,
    task: flags.TaskNames = None,
    robot: RobotName = None,
    looks: Looks = None,
    steps: flags.Steps = None,
    evaluation_episodes: EvaluationEpisodes = None,
    evaluate_every: flags.EvaluateEvery = None,
    out: flags.OutFolder = None,
    jobs: Jobs = None,
    executor: ExecutorName = "processes",
    budget: flags.BudgetTime = None,
    changed: flags.Changed = "refuse",
    measure: Measures = None,
    plugin: PluginFiles = None,
    screen: flags.Screen = False,
    quiet: flags.Quiet = False,
    as_json: flags.AsJson = False,
    dry_run: flags.DryRun = False,
    help_all: HelpAll = False,
) -> int:
    """Find the best of several rewards. It trains all of them, and drops those that are beaten.

    The candidates are the rewards of the files, or those that are named; the baseline takes part too.
    """
    given: dict[str, Any] = locals()
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import PluginFile, read_given, split_measures
    from harness.registry.registry import load_registry

    measures, files = split_measures(measure or ())
    plugins = read_given(plugin, files)
    given |= {"until": "best", "measure": measures or None, "seeds": None, "margin": None}
    given |= {"deterministic": None, "evaluation_horizon": None}
    given["looks"] = None if looks is None else flags.parse_looks(looks)
    plugins = tuple(replace(it, optional=True) if isinstance(it, PluginFile) else it for it in plugins)
    registry = load_registry(given=plugins)
    if reward is None and experiment is None and sim:
        given["reward"] = _candidates(registry, plugins)
    asked = flags.read_asked(experiment, given)
    options = RunOptions(out=out, jobs=jobs, executor=executor, budget=flags.parse_time(budget), changed=changed)
    if screen:
        _screen(asked, registry)
    if dry_run:
        return flags.foresee_run(asked, options, plugins, as_json)
    results, status = flags.train(asked, options, plugins, quiet)
    flags.show_run(results, as_json)
    if not as_json:
        _add(results, registry.broken_files())
    return status


def _candidates(registry: "Registry", plugins: "Sequence[Given]") -> list[str]:
    """The rewards that the given files register.

    Raises:
        UsageError: There is none.
    """
    names = {it.name for it in plugins}
    found = [spec.name for spec in registry.all_specs() if spec.kind == "rewards" and spec.plugin in names]
    if not found:
        raise UsageError(
            "which rewards? Name them, --reward arp,dense,relative, or give files of rewards, --plugin 'rewards/*.py'"
        )
    return found


def _screen(asked: "Experiment", registry: "Registry") -> None:
    """Say which candidates pay for not finishing, before anything is trained."""
    from harness.cli.audits import screened
    from harness.experiment.plan import expand

    say("Scripted movements, before anything is trained:", err=True)
    for line in screened(expand(asked, registry).cells, registry):
        say(f"  {line}", err=True)


def _add(results: "Results", left_out: Sequence[str]) -> None:
    """Why candidates are missing, and whether there is a race to tell of yet."""
    from harness.results.standing import standing_of

    for line in left_out:
        say(line)
    standing = standing_of(results)
    if standing is None or standing.race is None or not standing.race.looks:
        say("No look is complete yet: the same command goes on.")
