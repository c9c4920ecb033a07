"""``harness tune``: hyperparameters, with an equal budget for every reward."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cli.flags import tune as flags
from harness.cli.flags.shared import AsJson, ExecutorName, Jobs, Measures, PluginFiles, RewardNames, RobotName, TaskName
from harness.cli.output import kept_when_interrupted, say, say_json
from harness.errors import UsageError
from harness.text import command_text

_SEVERAL = re.compile(r",\s*\w+=")

if TYPE_CHECKING:
    from harness.executor import OnEvent
    from harness.record.cell import Cell
    from harness.tune.trial import TrialRecord, Tuned
    from harness.tune.tune import Watch
    from harness.tune.tuning import Tuning


def tune(
    file: flags.TuningFile = None,
    sim: flags.SimulatorName = None,
    algo: flags.AlgorithmName = None,
    reward: RewardNames = None,
    baseline: flags.Baseline = None,
    task: TaskName = None,
    robot: RobotName = None,
    measure: Measures = None,
    search: flags.Ranges = None,
    trials: flags.Trials = None,
    seeds: flags.Seeds = None,
    steps: flags.Steps = None,
    validation_episodes: flags.ValidationEpisodes = None,
    per_reward: flags.PerReward = None,
    pruner: flags.Pruner = None,
    batch: flags.Batch = None,
    seed: flags.Seed = None,
    out: flags.OutFolder = None,
    jobs: Jobs = None,
    executor: ExecutorName = "processes",
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Search the hyperparameters of one algorithm, with an equal budget for every reward.

    Writes DIR/tuned.toml, an experiment file for harness run. The same command goes on where it stopped.
    """
    from harness.experiment.run_options import RunOptions
    from harness.registry.given import read_given, split_measures
    from harness.registry.registry import load_registry
    from harness.tune.tune import resolve_in, run_searches

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
    from harness.tune.tuning import check_tuning, read_tuning

    return check_tuning(given) if path is None else read_tuning(path, given)


def _parse_search(texts: list[str] | None) -> dict[str, str] | None:
    if texts is None:
        return None
    from harness.tune.space import syntax_of

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
    from harness.cli.progress import LiveProgress
    from harness.tune.tune import Watch
    from harness.tune.tuning_table import outcome_text, params_text

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
    from harness.cli.terminal import show
    from harness.tune.tuning_table import tuning_table

    show(tuning_table(tuned), err=as_json)  # standard output belongs to the JSON, where it is asked for
    if tuned.file is None:
        say("No setting to recommend: a search has no complete trial", err=as_json)
    else:
        say(f"Tuned: {tuned.file} (next: {command_text('harness', 'run', tuned.file)})", err=as_json)
    if as_json:
        say_json(tuned.to_json())
