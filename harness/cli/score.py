"""``harness score``: what other rewards would have paid the same runs."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.datasets import names_dataset, score_dataset
from harness.cli.flags import inputs
from harness.cli.flags.dataset import Partial, Places
from harness.cli.flags.inputs import require_fit
from harness.cli.flags.shared import REWARDS, TASKS, AsJson, PluginFiles, RobotName, flag
from harness.cli.output import complain, say, say_json
from harness.cli.recordings import holds_recordings, is_experiment
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.experiment.environments.paid_again import Paid
    from harness.registry.choice import Registry


Targets = Annotated[
    list[str],
    typer.Argument(
        help="An experiment's folder, a folder of recorded trainings, a data set, or files.",
        metavar="DIR|DATASET|FILES",
    ),
]
PayingRewards = Annotated[
    list[str] | None,
    flag(
        "NAME,...",
        "The rewards that pay the runs again, such as arp:k2=2.",
        "in environments: all functions of --plugin",
        offers=REWARDS,
    ),
]
Every = Annotated[bool, typer.Option("--all", help="Also use every reward that the experiment trained with.")]
Environment = Annotated[
    str | None,
    flag("NAME", "The environment that recorded trainings were made in.", "by the id in the recording", offers=TASKS),
]
ScoresFolder = Annotated[
    Path | None, flag("DIR", "Folder for the scores of files or of a data set.", "beside each file")
]


def score(
    context: typer.Context,
    targets: Targets,
    reward: PayingRewards = None,
    every: Every = False,
    task: Environment = None,
    out: ScoresFolder = None,
    places: Places = None,
    partial: Partial = False,
    robot: RobotName = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Compute what other rewards would have paid for recorded runs. The recordings stay as they are."""
    from harness.registry.choice import split_list
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.results.recordings.recordings import has_recordings

    if any(map(names_dataset, targets)):
        if len(targets) > 1:
            raise UsageError("One data set is scored at a time: name it alone")
        require_fit(context, inputs.DATASET)
        return score_dataset(targets[0], split_list(reward or []), plugin, places, robot, out, partial, as_json)
    folder = Path(targets[0]) if len(targets) == 1 and Path(targets[0]).is_dir() else None
    if folder is not None and (has_recordings(folder) if is_experiment(folder) else holds_recordings([folder])):
        require_fit(context, inputs.RECORDINGS)
        registry = load_registry(given=read_given(plugin))
        return _score_recordings(folder, split_list(reward or []), every, task, registry, as_json)
    require_fit(context, inputs.FILES if folder is None else inputs.EXPERIMENT)
    if not reward and not every:
        raise UsageError("No reward is named: give --reward NAME, or --all for those of the experiment")
    registry, names = load_registry(given=read_given(plugin)), split_list(reward or [])
    if folder is not None:
        failed = _score_experiment(folder, names, every, registry, as_json)
    else:
        failed = _score_files(targets, names, out, registry, as_json)
    for label, reason in failed.items():
        complain(f"reward {label}: n/a ({reason})")
    return 1 if failed else 0


def _score_recordings(
    folder: Path, names: "Sequence[str]", every: bool, task: str | None, registry: "Registry", as_json: bool
) -> int:
    """Give the actions of recorded trainings to new envs, and pay them; status 1 if one could not be paid.

    With `every` and no name nothing is paid anew: what all rewards paid is recorded already. A reward that stands in no
    file and whose terms are recorded is paid from these.
    """
    from harness.experiment.environments.paid_again import PayAgain
    from harness.record.out_folder import refuse_links
    from harness.report.facts import return_facts
    from harness.report.tables.grid import FactsTable, show
    from harness.results.load import load_results
    from harness.score.weighted_recordings import recorded_weights, recordings_of

    refuse_links(folder)
    paths = [*recordings_of(folder)]
    functions = {it.name for it in registry.functions}
    weighted = {it: label for it in names if it not in functions and (label := recorded_weights(it, paths))}
    called = [name for name in names if name not in weighted]
    again = PayAgain(registry, called, task).run(folder) if called or not (every or weighted) else ()
    told = []
    for paid in chain(_paid_by_weights(paths, list(weighted.values())), again):
        told.append(paid)
        if not as_json:
            did = f"{paid.steps:,} steps by {', '.join(paid.names)}" if paid.names else "nothing to do, all is recorded"
            say(f"{paid.folder}: {f'n/a ({paid.refused})' if paid.refused else did}")
        for line in paid.failed:
            complain(f"{paid.folder}: {line}")
    # Of each group in the manner that says most, which comes first.
    returns = list({matrix.group: matrix for matrix in reversed(load_results(folder).returns)}.values())
    if as_json:
        matrices = [matrix.to_json() for matrix in returns]
        say_json({"recordings": [paid.to_json() for paid in told], "matrices": matrices})
    else:
        show(FactsTable(return_facts(returns)))
        say(f"What they come to: {command_text('harness', 'report', folder)}")
    return 1 if any(paid.refused or paid.failed for paid in told) else 0


def _paid_by_weights(paths: "Sequence[Path]", labels: "Sequence[str]") -> "Iterator[Paid]":
    """Pay recordings from the columns of their terms."""
    from harness.errors import HarnessError
    from harness.experiment.environments.paid_again import Paid
    from harness.score.weighted_recordings import pay_by_weights

    for path in paths:
        for label in labels:
            try:
                steps = pay_by_weights(path, label)
                yield Paid(path, (label,), steps) if steps else Paid(path)
            except HarnessError as error:
                yield Paid(path, refused=f"{label}: {error}")
            except OSError as error:
                yield Paid(path, refused=f"'{path}' cannot be written: {error.strerror or error}")


def _score_experiment(
    folder: Path, names: "Sequence[str]", every: bool, registry: "Registry", as_json: bool
) -> dict[str, str]:
    from harness.record.cell_log import cell_log
    from harness.record.folder import TRACE
    from harness.record.out_folder import refuse_links
    from harness.report.facts import score_facts
    from harness.report.tables.grid import FactsTable, show
    from harness.results.load import load_results
    from harness.results.score_matrix import score_matrices
    from harness.score.rescore import scoring_choice

    results = load_results(folder)
    refuse_links(folder)
    if not results.done_cells:
        raise UsageError(f"'{folder}' has no finished cell to score")
    cells = [results.store.cell_folder(cell) for cell in results.done_cells]
    scoring = [scoring_choice(name, registry, (cell_log(it / TRACE) for it in cells)) for name in names]
    trained = [cell.reward for cell in results.done_cells] if every else []
    matrices = score_matrices(results, list({it.label: it for it in [*scoring, *trained]}.values()), registry)
    if as_json:
        say_json({"matrices": [matrix.to_json() for matrix in matrices]})
    else:
        show(FactsTable(score_facts(matrices)))
        say(f"What each step pays: scores.parquet in each folder of {results.store.folder / 'cells'}")
    return {label: reason for matrix in matrices for label, reason in matrix.failed.items()}


def _score_files(
    patterns: Sequence[str], names: "Sequence[str]", out: Path | None, registry: "Registry", as_json: bool
) -> dict[str, str]:
    from harness.record.folder import SCORES
    from harness.score.open_steps import match_steps
    from harness.score.rescore import rescore, scoring_choice

    logs = match_steps(patterns, registry)
    files = [log.facts.path for log in logs]
    places = [(out or path.parent) / f"{path.stem}.{SCORES}" for path in files]
    if len(set(places)) < len(places):
        raise UsageError(
            f"Several files of one name cannot all be scored into '{out}': leave out --out, or rename the files"
        )
    scoring = [scoring_choice(name, registry, logs) for name in names]
    written, failed = [], dict[str, str]()
    for log, into in zip(logs, places, strict=True):
        refused = rescore(log, scoring, into, registry)
        failed |= refused
        paid = [item.label for item in scoring if item.label not in refused]
        written.append({"file": str(log.facts.path), "scores": str(into), "rewards": paid})
    if as_json:
        say_json({"files": written})
    else:
        for entry in written:
            say(f"{entry['file']} -> {entry['scores']}")
    return failed
