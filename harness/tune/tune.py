"""Search the hyperparameters of one algorithm, with an equal budget for every reward."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from harness.executor import OnEvent
from harness.experiment.experiment import DEFAULT_FOLDER
from harness.experiment.run_options import RunOptions
from harness.record.cell import Cell
from harness.registry.choice import Choice
from harness.registry.given import read_given
from harness.registry.registry import Registry, load_registry
from harness.tune.folder import begun_with, tuning_folder
from harness.tune.outcome import JUDGES
from harness.tune.outcomes import Follow, TrainedOutcomes
from harness.tune.search import Searcher
from harness.tune.study import Study, open_storage, require_optuna
from harness.tune.trial import Search, TrialRecord, Tuned
from harness.tune.tuned_file import write_tuned
from harness.tune.tuning import Setup, Tuning, check_tuning, resolve

OnTrial: TypeAlias = Callable[[tuple[str, ...], TrialRecord], None]
"""A function that is told the rewards of the search and each trial that has ended."""


@contextmanager
def _follow_nothing(cells: Sequence[Cell], done: Sequence[Cell]) -> Iterator[OnEvent]:
    yield lambda event: None


@dataclass(frozen=True)
class Watch:
    """The functions that are told what happens; by default none."""

    follow: Follow = _follow_nothing
    on_trial: OnTrial = lambda rewards, trial: None


def tune(
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    executor: str | Mapping[str, Any] = "processes",
    plugins: Iterable[str | Path | type] = (),
    **tuning: Any,
) -> Tuned:
    """Do the trials that are not done yet, and write the best settings as an experiment file.

    Args:
        out: The tuning's folder; by default one under ``results/runs/`` named for the search, so that the same call
            goes on where an earlier one stopped.
        jobs: How many cells at once; by default as many as there are cores. The trials do not depend on it.
        executor: What runs the cells, with its settings.
        plugins: Files and classes beside the installed plugins; see `harness.registry.given.read_given`.
        **tuning: The fields of `harness.tune.tuning.Tuning`; the lists may be single names.

    Raises:
        UsageError: Something given cannot be used, or Optuna is missing; nothing is written.
    """
    options, registry = RunOptions(jobs=jobs, executor=executor), load_registry(given=read_given(plugins))
    setup, folder = resolve_in(out, check_tuning(tuning), registry)
    return run_searches(setup, folder, registry, options)


def resolve_in(out: str | Path | None, tuning: Tuning, registry: Registry) -> tuple[Setup, Path]:
    """A resolved search, and its folder. A folder that was begun goes on with the defaults that it was begun with.

    Raises:
        UsageError: As `resolve`, or what the folder holds cannot be read.
    """

    def folder_of(setup: Setup) -> Path:
        return Path(out) if out else default_folder(setup)

    setup = resolve(tuning, registry, lambda setup: begun_with(folder_of(setup), registry))
    return setup, folder_of(setup)


def default_folder(setup: Setup) -> Path:
    """A folder named for what is searched, so that the same search finds its trials again."""
    places = setup.experiment.get("sim") or [setup.experiment["task"]]
    names = f"{places[0]['name']}-{setup.base.name}".replace("/", "-")  # of a qualified name
    return DEFAULT_FOLDER / f"tune-{names}-{setup.id}"


def run_searches(
    setup: Setup, folder: Path, registry: Registry, options: RunOptions, watch: Watch | None = None
) -> Tuned:
    """Every search of a setup, one after the other, in `folder`.

    Raises:
        UsageError: Optuna is missing, an executor or a metric is not known, the folder cannot be used, or trials in it
            were done by other plugins than those installed and some are still to be done.
    """
    watch = watch or Watch()
    require_optuna()
    for metric in JUDGES if setup.experiment.get("sim") else ():
        registry.get("metrics", metric)
    executor = options.build_executor(registry)
    with tuning_folder(folder, setup):
        trained = TrainedOutcomes(folder, registry, setup.tuning.validation_episodes, options, executor, watch.follow)
        trained.forget_failures()
        studies = _open_studies(setup, folder)
        if not all(study.is_over(setup.tuning.trials) for _, study in studies.values()):
            trained.require_same_plugins()
        for labels, (rewards, study) in studies.items():
            Searcher(setup, rewards, study, registry, trained, _told(watch.on_trial, labels)).run()
        searches = tuple(Search(labels, tuple(study.trials)) for labels, (_, study) in studies.items())
        return Tuned(folder, searches, write_tuned(folder, setup, searches, registry))


def _open_studies(setup: Setup, folder: Path) -> dict[tuple[str, ...], tuple[tuple[Choice, ...], Study]]:
    """The rewards and the study of each search, by the rewards' labels. All studies draw from the same seed."""
    storage, tuning = open_storage(folder), setup.tuning
    named = {tuple(reward.label for reward in rewards): rewards for rewards in setup.searches}
    return {
        labels: (
            rewards,
            Study(storage, ", ".join(labels), setup.space, seed=tuning.seed, pruner=tuning.pruner),
        )
        for labels, rewards in named.items()
    }


def _told(on_trial: OnTrial, labels: tuple[str, ...]) -> Callable[[TrialRecord], None]:
    return lambda trial: on_trial(labels, trial)
