"""The results of the logs in a folder, as of recorded trainings: what was found, then what it says."""

import glob
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.eta.laws import is_left_out
from harness.log import Log
from harness.log.open_log import LOGS, Found, find_logs, open_logs
from harness.registry.choice import Registry
from harness.results.logs.labels import labelled
from harness.results.logs.read_logs import Other, runs_of
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.logs.trainings import Sorted, require_several, sort_files, sort_logs
from harness.results.recordings.recordings import Recordings, plan_of
from harness.results.recordings.runs import called_alike
from harness.results.results import Results
from harness.reward.steps import ENDS
from harness.text import command_text

MOST_NAMED = 5


def results_of_logs(
    folder: Path,
    registry: Registry,
    told: Told = FOUND_OUT,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | None = None,
    *,
    pairs: bool = False,
) -> Results:
    """The results of all logs in a file, or below a folder.

    Args:
        folder: Where they lie.
        registry: Has the formats.
        told: What the user says of them.
        kind: Which curves the indices are read from.
        metrics: Which measures are shown, beside the one that decides; all of them if None.
        pairs: Whether every two rewards are compared, and not each with the baseline alone.

    Raises:
        UsageError: There is no log, or the trainings cannot be compared; says what was found and what to do.
        SchemaError: A log is damaged.
    """
    found = _opened(folder, registry, told)
    if not any(log.facts.unit != "step" or {*ENDS} & {*log.names} for log in found.logs):
        raise UsageError(
            f"'{folder}' holds steps that do not tell where episodes end: {_command_of_steps(folder)} compares their "
            "pay"
        )
    place = folder if folder.is_dir() else folder.parent
    sorted_, other = sort_found(folder, found, told)
    if not told.sort:
        require_several(place, sorted_)
    return _results(place, registry, sorted_, told, kind, other, metrics, pairs=pairs)


def sort_found(folder: Path, found: Found, told: Told) -> tuple[Sorted, list[Other]]:
    """The trainings of what was found in a file or below a folder, and those of which nothing is read.

    Raises:
        UsageError: As `sort_logs`; or all of them are left out.
    """
    logs, other = _kept(found.logs, told)
    if not logs:
        raise UsageError(f"--leave-out leaves no training of '{folder}'")
    sorted_ = sort_logs(folder if folder.is_dir() else folder.parent, logs, told.sort, told.baseline)
    unread, lines = _unread(folder, found, sorted_)
    return sorted_._replace(notes=(*sorted_.notes, *lines)), [*other, *unread]


def _kept(logs: Iterable[Log], told: Told) -> tuple[list[Log], list[Other]]:
    """The logs that the user does not leave out, and the others."""
    places = [(log, log.facts.path / log.facts.run) for log in logs]
    out = [(place, "") for _, place in places if is_left_out(place, told.leave_out)]
    return [log for log, place in places if (place, "") not in out], out


def _unread(folder: Path, found: Found, of: Sorted) -> tuple[list[Other], list[str]]:
    """Trainings that left no log, or one that cannot be read; and a line for what cannot be read beside a log of one.

    A file or folder without a log is of a training if it is called as logs, or folders of logs, are.
    """
    kept = [log.facts.path for it in of.trainings for log in it.logs]
    why, homes = dict(found.left_out), {it.parent for it in kept}
    alike = called_alike(folder, kept, of.rewards, [log.facts.path for log in found.logs])
    beside = [it for it in why if it.parent in homes and it not in alike]
    silent = [it for it in alike if not any(it in (path, *path.parents) for path in why)]
    lost = [it for it in found.left_out if it[0] not in beside]
    told = [(it, "nothing in it is a log" if it.is_dir() else "it is no log") for it in silent]
    return [*lost, *told], [f"'{it}' is left out: {why[it]}" for it in beside]


def results_of_groups(
    groups: Sequence[Sequence[Path]], registry: Registry, told: Told = FOUND_OUT, kind: Kind = "accumulated"
) -> Results:
    """The same of two groups of files that the user names.

    Args:
        groups: The files of the baseline, and those of the proposed reward.
        registry: Has the formats.
        told: What the user says of them.
        kind: Which curves the indices are read from.

    Raises:
        UsageError: As `results_of_logs`; or a file is in both groups, or none is a log.
    """
    dropped = [(path, "") for paths in groups for path in paths if is_left_out(path, told.leave_out)]
    kept = [[path.absolute() for path in paths if (path, "") not in dropped] for paths in groups]
    if not all(kept):
        raise UsageError("--leave-out leaves no training of one of the groups: leave out fewer, or name more files")
    opened = {path: _opened(path, registry, told, is_whole=True).logs for paths in kept for path in paths}
    both = [path for path in kept[0] if path in kept[1]]
    if both:
        raise UsageError(f"'{both[0]}' is in both groups: let --baseline and --proposed name different files")
    place = Path(os.path.commonpath([path.parent for path in opened]))
    named = sort_files(place, list(opened), is_asked=False)
    ours, theirs = ([name for name, of in named.items() if {*of} & {*paths}] for paths in kept)
    is_told = len(ours) == len(theirs) == 1 and ours != theirs
    names = [*ours, *theirs] if is_told else ["baseline", "proposed"]
    logs, other = _kept(
        (
            replace(log, facts=replace(log.facts, trained_with=name))
            for name, paths in zip(names, kept, strict=True)
            for path in paths
            for log in opened[path]
        ),
        told,
    )
    return _results(place, registry, sort_logs(place, logs, told.sort, names[0]), told, kind, [*dropped, *other])


def _opened(path: Path, registry: Registry, told: Told, *, is_whole: bool = False) -> Found:
    """What lies there without the file of labels, which may look like a log.

    Args:
        path: The file or the folder.
        registry: Has the formats.
        told: What the user says.
        is_whole: Whether nothing in it may be damaged.

    Raises:
        UsageError: Nothing that can be read.
    """
    found, labels = find_logs(path, registry, told.format), [told.labels] if told.labels else []
    logs = tuple(log for log in found.logs if not is_left_out(log.facts.path, labels))
    found = Found(logs, tuple(it for it in found.left_out if not is_left_out(it[0], labels)))
    if not found.logs or (is_whole and found.left_out):
        raise _nothing(path, registry, [f"{place}: {reason}" for place, reason in found.left_out])
    return found


def _results(
    place: Path,
    registry: Registry,
    found: Sorted,
    told: Told,
    kind: Kind,
    other: Iterable[Other] = (),
    metrics: Iterable[str] | None = None,
    *,
    pairs: bool = False,
) -> Results:
    if told.per_step:
        found = _in_steps(found, registry, told)
    if told.labels is not None:
        found = labelled(found, place, told.labels)
    runs = runs_of(found, told.deciding, other, told.leave_out)
    told = replace(told, leave_out=())
    return Recordings(place, registry, plan_of(runs), kind, metrics=metrics, pairs=pairs, told=told, loose=runs)


def _in_steps(found: Sorted, registry: Registry, told: Told) -> Sorted:
    """The same, read again by formats that are told how many steps an iteration is."""
    steps = told.steps_of(found.rewards)

    def again(log: Log, per_step: int) -> Log:
        logs = open_logs(log.facts.path, registry, told.format or log.facts.reader, per_step=per_step)
        return next(it for it in logs if it.facts.run == log.facts.run)

    trainings = [replace(it, logs=tuple(again(log, steps[it.reward]) for log in it.logs)) for it in found.trainings]
    return found._replace(trainings=tuple(trainings))


def _nothing(folder: Path, registry: Registry, damaged: Sequence[str]) -> UsageError:
    """Says which formats there are, and what was seen instead."""
    if damaged:
        return UsageError(f"'{folder}' holds no log that can be read: {'; '.join(damaged[:MOST_NAMED])}")
    files = (it for it in (folder, *folder.rglob("*")) if it.is_file())
    endings = Counter(it.suffix or "without an ending" for it in files).most_common(MOST_NAMED)
    seen = ", ".join(f"{count} {ending}" for ending, count in endings) or "nothing"
    steps = f"; {_command_of_steps(folder)} compares CSV files if a row is a step" if ".csv" in dict(endings) else ""
    return UsageError(
        f"'{folder}' is no experiment, and holds no recorded training and no log that is read. Seen: {seen}. Formats: "
        f"{', '.join(registry.names(LOGS))}; --as table:time=TIME,success=SUCCESS says which columns of a table "
        f"count{steps}"
    )


def _command_of_steps(path: Path) -> str:
    groups = ("--baseline", glob.escape(str(path)), "--proposed", "OTHER/*.csv")
    return command_text("harness", "eta", *([path] if path.is_dir() else groups))
