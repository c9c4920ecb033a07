"""The results of the logs in a folder, as of recorded trainings: what was found, then what it says."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.log import Log
from harness.log.open_log import LOGS, find_logs, open_logs
from harness.registry.choice import parse
from harness.registry.registry import Registry
from harness.results.logs.labels import labelled
from harness.results.logs.read_logs import SUCCESS_DECIDES, Deciding, runs_of
from harness.results.logs.trainings import Sorted, sort_logs, with_reward
from harness.results.recordings.loose import LooseStore
from harness.results.recordings.results import RecordedResults

MOST_NAMED = 5


@dataclass(frozen=True)
class Told:
    """What a user says of logs. Everything else is found out.

    Attributes:
        format: The format with its settings, ``monitor:success=is_success``.
        sort: How names are made, ``{reward}/{seed}``.
        baseline: The reward that the others are compared with.
        deciding: What decides.
        labels: A file that says which trainings, or episodes, were successes.
    """

    format: str = ""
    sort: str = ""
    baseline: str = ""
    deciding: Deciding = SUCCESS_DECIDES
    labels: Path | None = None


FOUND_OUT = Told()


def parse_deciding(text: str) -> Deciding:
    """What ``--measure`` says of logs: ``success``, ``length:better=lower``.

    Raises:
        UsageError: It is malformed.
    """
    name, params = parse(text) if text else ("", {})
    better = params.pop("better", "")
    if params or better not in ("", "higher", "lower"):
        raise UsageError(f"--measure {text}: write NAME, NAME:better=higher or NAME:better=lower")
    return Deciding(name, better)


def results_of_logs(
    folder: Path,
    registry: Registry,
    told: Told = FOUND_OUT,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | None = None,
    *,
    pairs: bool = False,
) -> RecordedResults:
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
    found = find_logs(folder, registry, told.format)
    if not found.logs:
        raise _nothing(folder, registry, [f"{path}: {reason}" for path, reason in found.left_out])
    place = folder if folder.is_dir() else folder.parent
    sorted_ = sort_logs(place, found.logs, told.sort, told.baseline)
    lines = [f"'{path}' is left out: {reason}" for path, reason in found.left_out]
    return _results(place, registry, sorted_._replace(notes=(*sorted_.notes, *lines)), told, kind, metrics, pairs=pairs)


def results_of_groups(
    groups: Mapping[str, Sequence[Path]], registry: Registry, told: Told = FOUND_OUT, kind: Kind = "accumulated"
) -> RecordedResults:
    """The same of two groups of files that the user names, the baseline's first.

    Args:
        groups: The files of each, by the name of the reward.
        registry: Has the formats.
        told: What the user says of them.
        kind: Which curves the indices are read from.
    """
    logs: list[Log] = []
    for reward, paths in groups.items():
        logs += with_reward((log for path in paths for log in open_logs(path, registry, told.format)), reward)
    place = Path(os.path.commonpath([path.absolute().parent for paths in groups.values() for path in paths]))
    found = sort_logs(place, logs, told.sort, next(iter(groups)))
    return _results(place, registry, found, told, kind, is_told=True)


def _results(
    place: Path,
    registry: Registry,
    found: Sorted,
    told: Told,
    kind: Kind,
    metrics: Iterable[str] | None = None,
    *,
    pairs: bool = False,
    is_told: bool = False,
) -> RecordedResults:
    if told.labels is not None:
        found = labelled(found, place, told.labels)
    runs = runs_of(found, told.deciding, is_told=is_told or bool(told.sort))
    return RecordedResults(place, registry, kind, metrics=metrics, store=LooseStore(place, runs), pairs=pairs)


def _nothing(folder: Path, registry: Registry, damaged: Sequence[str]) -> UsageError:
    """Says which formats there are, and what was seen instead."""
    if damaged:
        return UsageError(f"'{folder}' holds no log that can be read: {'; '.join(damaged[:MOST_NAMED])}")
    endings = _endings(folder)
    seen = ", ".join(f"{count} {ending}" for ending, count in endings.items()) or "nothing"
    return UsageError(
        f"'{folder}' is no experiment, and holds no recorded training and no log that is read. Seen: {seen}. Formats: "
        f"{', '.join(registry.names(LOGS))}; --as FORMAT:setting=value names one"
    )


def _endings(folder: Path) -> dict[str, int]:
    """How many files of each ending lie below a folder, those that there are most of first."""
    files: Iterable[str] = (
        [folder.name] if folder.is_file() else (it for _, _, names in os.walk(folder) for it in names)
    )
    counts: dict[str, int] = {}
    for name in files:
        ending = Path(name).suffix or "without an ending"
        counts[ending] = counts.get(ending, 0) + 1
    return dict(sorted(counts.items(), key=lambda it: -it[1])[:MOST_NAMED])
