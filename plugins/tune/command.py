"""``harness tune``: hyperparameters, with an equal budget for every reward."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.authoring.commands import (
    ALGORITHMS,
    REWARDS,
    SIMULATORS,
    AsJson,
    ExecutorName,
    Jobs,
    Measures,
    PluginFiles,
    RewardNames,
    RobotName,
    TaskName,
    kept_when_interrupted,
    say,
    say_json,
)
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.authoring.commands import Cell
    from harness.executor import OnEvent

    from .trial import TrialRecord, Tuned
    from .tune import Watch
    from .tuning import Tuning


TuningFile = Annotated[
    Path | None,
    typer.Argument(help="Tuning file (TOML). Its keys are named like the flags; a flag overrides its key."),
]
SimulatorName = Annotated[
    list[str] | None, typer.Option(help="The simulator.", metavar="NAME", autocompletion=SIMULATORS)
]
AlgorithmName = Annotated[
    list[str] | None,
    typer.Option(
        help="The algorithm, with parameters that stay fixed, such as sac:tau=0.01.",
        metavar="NAME",
        autocompletion=ALGORITHMS,
    ),
]
Baseline = Annotated[
    str | None,
    typer.Option(
        help="The reward that the others are compared with. It is tuned too.",
        show_default="baseline",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Ranges = Annotated[
    list[str] | None,
    typer.Option(
        help="The ranges to search: gamma=0.9..0.999, learning_rate=1e-4..1e-2:log, net_arch=64x64|256x256.",
        show_default="learning_rate and gamma",
        metavar="KEY=SPACE",
    ),
]
Trials = Annotated[
    int | None, typer.Option(help="How many settings (trials) each search tries.", show_default="20", metavar="N")
]
Seeds = Annotated[
    int | None,
    typer.Option(help="How often each setting is trained with each reward.", show_default="2", metavar="N"),
]
Steps = Annotated[
    int | None, typer.Option(help="Environment steps of each training.", show_default="10000", metavar="N")
]
ValidationEpisodes = Annotated[
    int | None,
    typer.Option(help="Episodes of the validation that judges each policy.", show_default="100", metavar="N"),
]
PerReward = Annotated[
    bool | None, typer.Option("--per-reward/--joint", help="Search once for each reward, or once for all together.")
]
Pruner = Annotated[
    str | None,
    typer.Option(help="What ends bad trials early: median or none.", show_default="median", metavar="NAME"),
]
Batch = Annotated[
    int | None,
    typer.Option(
        help="How many trials are drawn together, so that they can run at once.", show_default="1", metavar="N"
    ),
]
Seed = Annotated[
    int | None, typer.Option(help="The seed for drawing settings from the ranges.", show_default="0", metavar="S")
]
OutFolder = Annotated[
    Path | None, typer.Option(help="The tuning's folder.", show_default="one under results/runs/", metavar="DIR")
]
_SEVERAL = re.compile(r",\s*\w+=")


def tune(
    file: TuningFile = None,
    sim: SimulatorName = None,
    algo: AlgorithmName = None,
    reward: RewardNames = None,
    baseline: Baseline = None,
    task: TaskName = None,
    robot: RobotName = None,
    measure: Measures = None,
    search: Ranges = None,
    trials: Trials = None,
    seeds: Seeds = None,
    steps: Steps = None,
    validation_episodes: ValidationEpisodes = None,
    per_reward: PerReward = None,
    pruner: Pruner = None,
    batch: Batch = None,
    seed: Seed = None,
    out: OutFolder = None,
    jobs: Jobs = None,
    executor: ExecutorName = "processes",
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Search the hyperparameters of one algorithm, with an equal budget for every reward.

    Writes DIR/tuned.toml, an experiment file for harness run. The same command goes on where it stopped.
    """
    from harness.authoring.commands import RunOptions, load_registry, read_given, split_measures

    from .tune import resolve_in, run_searches

    measures, files = split_measures(measure or ())
    options = RunOptions(jobs=jobs, executor=executor)
    given = {
        "sim": sim, "algo": algo, "reward": reward, "baseline": baseline, "task": task, "robot": robot,
        "search": _parse_search(search), "trials": trials, "seeds": seeds, "steps": steps,
        "validation_episodes": validation_episodes, "per_reward": per_reward, "pruner": pruner, "batch": batch,
        "seed": seed, "measure": measures or None,
    }  # fmt: skip
    registry = load_registry(given=read_given(plugin, files))
    tuning = _read(file, {key: value for key, value in given.items() if value is not None})
    setup, folder = resolve_in(out, tuning, registry)
    with kept_when_interrupted("finished cells are kept", folder):
        tuned = run_searches(setup, folder, registry, options, _watch(setup.tuning.trials))
    _show(tuned, as_json)
    return 1 if tuned.failed or tuned.file is None else 0


def _read(path: Path | None, given: dict[str, Any]) -> "Tuning":
    from .tuning import check_tuning, read_tuning

    return check_tuning(given) if path is None else read_tuning(path, given)


def _parse_search(texts: list[str] | None) -> dict[str, str] | None:
    if texts is None:
        return None
    from .space import syntax_of

    search: dict[str, str] = {}
    for text in texts:
        name, _, space = (part.strip() for part in text.partition("="))
        if not (name and space):
            what = f"no values of '{name}'" if name else "no parameter"
            raise UsageError(f"--search '{text}' names {what}: {syntax_of(name or 'KEY')}")
        if _SEVERAL.search(space):
            raise UsageError(f"--search '{text}' names several parameters: give --search once for each")
        if name in search:
            raise UsageError(f"--search names '{name}' twice")
        search[name] = space
    return search


def _watch(trials: int) -> "Watch":
    from harness.authoring.commands import LiveProgress

    from .table import outcome_text, params_text
    from .tune import Watch

    @contextmanager
    def follow(cells: "Sequence[Cell]", done: "Sequence[Cell]") -> "Iterator[OnEvent]":
        with LiveProgress(cells, done) as progress:
            yield progress

    def tell(rewards: tuple[str, ...], trial: "TrialRecord") -> None:
        values = ", ".join(f"{name} {text}" for name, text in outcome_text(trial).items())
        told = f": {trial.reason or values}"
        where = f"[trial {trial.number + 1}/{trials}] {' and '.join(rewards)}"
        say(f"{where} · {params_text(trial)} · {trial.status}{told}", err=True)

    return Watch(follow, tell)


def _show(tuned: "Tuned", as_json: bool) -> None:
    from harness.authoring.commands import show

    from .table import tuning_table

    show(tuning_table(tuned), err=as_json)  # standard output belongs to the JSON, where it is asked for
    if tuned.file is None:
        say("No setting to recommend: a search has no complete trial", err=as_json)
    else:
        say(f"Tuned: {tuned.file} (next: {command_text('harness', 'run', tuned.file)})", err=as_json)
    if as_json:
        say_json(tuned.to_json())


tune.examples = ("harness tune --sim mujoco --algo sac --reward arp",)  # type: ignore[attr-defined] # harness shows them
