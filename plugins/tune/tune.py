"""Search the hyperparameters of one algorithm, with an equal budget for every reward.

Its folder::

    tuning.toml           what is searched; reads as a tuning file
    study.log             Optuna's journal of the trials
    trials/               an experiment with the cells of all trials
    validation/<cell id>/ evaluation.parquet: the episodes that the policy was judged by; log.txt
    tuned.toml            an experiment with the best settings, once every search has all its trials
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import tomli_w

from harness.authoring.commands import (
    DEFAULT_FOLDER,
    Cell,
    Choice,
    Registry,
    RunOptions,
    choose,
    folder_lock,
    is_partial,
    load_registry,
    make_folder,
    read_given,
    read_toml,
    refuse_links,
    storage_errors,
    table_of,
    write_whole,
)
from harness.errors import UsageError
from harness.executor import OnEvent
from harness.text import shortened

from .outcomes import VALIDATION_SEED, Follow, TrainedOutcomes
from .search import Searcher
from .study import JOURNAL, Study, open_storage, require_optuna
from .trial import JUDGES, Search, TrialRecord, Tuned
from .tuning import FIRST_SEED, Setup, Tuning, check_tuning, resolve

OnTrial: TypeAlias = Callable[[tuple[str, ...], TrialRecord], None]
"""A function that is told the rewards of the search and each trial that has ended."""
SHOWN = 80
"""The most characters of a value in a message."""
TUNING, TUNED, LOCK = "tuning.toml", "tuned.toml", ".lock"


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
        **tuning: The fields of `harness_plugins.tune.tuning.Tuning`; the lists may be single names.

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


@contextmanager
def tuning_folder(folder: Path, setup: Setup) -> Iterator[None]:
    """Make the folder, or go on with one of the same search, and keep others out of it.

    Raises:
        UsageError: It cannot be written, holds something else or another search, or is in use. Nothing is written.
    """
    _require_same(folder, setup)
    make_folder(folder)
    refuse_links(folder, grows=JOURNAL)
    with storage_errors(folder), folder_lock(folder / LOCK, f"Another search is using '{folder}'"):
        write_whole(folder / TUNING, tomli_w.dumps({**setup.keys, "trials": setup.tuning.trials}))
        yield


def begun_with(folder: Path, registry: Registry) -> list[Choice]:
    """The algorithm of the search that a folder holds; nothing if it holds none.

    Raises:
        UsageError: The search cannot be read.
    """
    if not (folder / TUNING).is_file():
        return []
    return [choose(registry, "algorithms", it) for it in read_toml(folder / TUNING, "tuning file").get("algo", [])]


def _require_same(folder: Path, setup: Setup) -> None:
    """Check that a search is the same as the folder's. It may ask for more trials; any other difference is refused."""
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"--out '{folder}' is a file: name a folder")
    if not (folder / TUNING).is_file():
        if folder.is_dir() and {path.name for path in folder.iterdir() if not is_partial(path)} - {LOCK}:
            raise UsageError(f"--out '{folder}' holds something else than a tuning: name a new or empty folder")
        return
    there = read_toml(folder / TUNING, "tuning file")
    for key, value in setup.keys.items():
        if there.get(key) != value:
            now, then = (shortened(str(one), SHOWN) for one in (value, there.get(key)))
            raise UsageError(f"--out '{folder}' holds another search: {key} was {then}, now {now}: name another folder")


def write_tuned(folder: Path, setup: Setup, searches: Sequence[Search], registry: Registry) -> Path | None:
    """Write the best settings as an experiment file; None if a search has trials to do, or no complete one.

    With a search for each reward every reward meets the best settings of all: an experiment is a full matrix.
    """
    best = [search.best for search in searches]
    chosen = [trial for trial in best if trial is not None]
    if len(chosen) < len(best) or any(_is_open(search, setup) for search in searches):
        return None
    algorithms = list(
        dict.fromkeys(choose(registry, "algorithms", {**table_of(setup.base), **trial.params}) for trial in chosen)
    )
    plan = setup.plan(algorithms, setup.rewards, registry)
    resolved = {key: value for key, value in plan.resolved.items() if value is not None}
    write_whole(folder / TUNED, _comment(setup, searches) + tomli_w.dumps(resolved))
    return folder / TUNED


def _is_open(search: Search, setup: Setup) -> bool:
    ended = [trial for trial in search.trials if trial.status != "running"]
    return len(ended) < setup.tuning.trials


def _comment(setup: Setup, searches: Sequence[Search]) -> str:
    """Where the settings come from, for the reader of the file."""
    lines = [f"Chosen by harness tune: {setup.tuning.trials} trials, {setup.tuning.seeds} seeds from {FIRST_SEED} on,"]
    lines += [f"validation seed {VALIDATION_SEED}; harness run trains and evaluates with others."]
    lines += [_choice_line(search, search.best) for search in searches if search.best]
    return "".join(f"# {line}\n" for line in lines)


def _choice_line(search: Search, best: TrialRecord) -> str:
    settings = ", ".join(f"{key}={value}" for key, value in best.params.items())
    return f"{' and '.join(search.rewards)}: trial {best.number}, {settings}"
