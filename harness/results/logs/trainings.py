"""Sorts the logs of a folder into trainings: which reward taught each, with which seed, and which log tells it best."""

import hashlib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from harness.errors import UsageError
from harness.eta.amounts import listed
from harness.eta.laws import numbered
from harness.log import Log, LogFacts
from harness.log.facts import Unit
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS, TIME, Rows
from harness.results.logs.names import Named, in_lockstep, question, sort_names, templates_of
from harness.text import command_text

UNITS: tuple[Unit, ...] = ("step", "episode", "point")
"""The finest first."""
PLAIN_FILES = ("monitor", "evaluations", "progress", "result", "results", "metrics", "episodes", "log", "data")
PLAIN_FOLDERS = ("eval", "evaluation", "evaluations", "tb", "tensorboard", "log", "logs", "monitor", "runs", "train")
"""Names that programs give to what belongs to any training: they say nothing of it."""
EVENTS = "events.out.tfevents"
ENDING = re.compile(r"\.monitor\.csv$|(?<=.)\.[^.]+$", re.IGNORECASE)
"""Behind the name of a file."""
NUMBERED = re.compile("[0-9]+([.][0-9]+)*")
"""Names of files which a batch of environments writes: a number, or one of a process and one of its environment."""
EVALUATED = re.compile("eval(uation)?s?([-_](env|logs?|monitor))?", re.IGNORECASE)
"""Names of files and folders of an environment in which policies were evaluated."""
TOLD = (REWARD, BEHAVIOUR)
"""Beginnings of names of columns that tell what a training came to."""
FEWEST = 5
"""Values that the beginning of a training has to have, so that an equal one is no chance."""
Key: TypeAlias = tuple[str, int | None, str]
"""The reward and the seed of a training; without a seed, the name that says it."""


@dataclass(frozen=True, eq=False)
class Training:
    """One training, and the logs that tell it.

    Attributes:
        reward: The name of the reward that taught it.
        seed: Of the training, or the number that it was given.
        logs: What was kept of it; several where each environment of a batch has a file of its own.
        evaluation: What policies did without being trained; None where nobody kept it.
    """

    reward: str
    seed: int
    logs: tuple[Log, ...]
    evaluation: Log | None = None

    @property
    def facts(self) -> LogFacts:
        """What its log tells, with the reward and the seed that it has."""
        return replace(self.logs[0].facts, trained_with=self.reward, seed=self.seed)

    @property
    def path(self) -> Path:
        """The file or the folder of its log; of several files their folder."""
        return self.facts.path if len(self.logs) == 1 else self.facts.path.parent

    @property
    def place(self) -> Path:
        """The same with what a file that holds several calls it."""
        return self.path / self.facts.run

    @property
    def shown(self) -> str:
        """The path in words, with what the file calls the training."""
        run = self.facts.run
        return f"'{self.path}'{f' ({run})' if run else ''}"

    @property
    def all_logs(self) -> tuple[Log, ...]:
        """Those of the training and that of its evaluations."""
        return self.logs if self.evaluation is None else (*self.logs, self.evaluation)

    @property
    def evaluated(self) -> Log | None:
        """What policies did without being trained; what somebody else says of it comes first."""
        return self.logs[0] if self.evaluation is None and self.facts.evaluation else self.evaluation


class Sorted(NamedTuple):
    """The trainings of a folder."""

    trainings: tuple[Training, ...]
    """By reward and seed, the baseline's first."""
    notes: tuple[str, ...]
    """How they were sorted, a line each."""

    @property
    def rewards(self) -> tuple[str, ...]:
        """The names of the rewards; the baseline first."""
        return tuple(dict.fromkeys(it.reward for it in self.trainings))

    @property
    def sentence(self) -> str:
        """What was found, in a line: ``10 trainings of 2 rewards: base 5, prop 5``."""
        counts = ", ".join(f"`{name}` {sum(it.reward == name for it in self.trainings)}" for name in self.rewards)
        trainings, rewards = len(self.trainings), len(self.rewards)
        plain = f"{trainings} training{'s' * (trainings != 1)} of {rewards} reward{'s' * (rewards != 1)}: {counts}"
        return f"{plain}; the baseline is `{self.rewards[0]}`" if rewards > 1 else plain


def sort_logs(folder: Path, logs: Sequence[Log], template: str = "", baseline: str = "") -> Sorted:
    """The trainings that logs tell of.

    What a log tells of its reward and seed counts; else names of files and folders say it.

    Args:
        folder: Where they lie: names below it count.
        logs: All of them, of any formats.
        template: How names are made, if the user says it; see `sort_by_template`.
        baseline: The reward that the others are compared with; found by its name if empty.

    Raises:
        UsageError: Names can be read in two ways, two logs are of one reward and one seed, a name does not fit the
            template, or there is no such reward.
    """
    notes: list[str] = []
    logs = _without_evaluated(folder, logs, notes)
    names = {log: _name_of(folder, log.facts.path, log.facts.run) for log in logs}
    if all(map(NUMBERED.fullmatch, names.values())):  # of one reward, whose name is the folder's
        names = {log: f"{folder.resolve().name}/{name}" for log, name in names.items()}
    if not template:
        names |= _batches(folder, names, notes)
    named, found = _named(folder, names, template), dict[Key, list[Log]]()
    for log in names:
        of = named[log]
        found.setdefault((of.reward, of.seed, of.place if of.seed is None else ""), []).append(log)
    best = {key: _best_of(key, of, names, is_told=bool(template)) for key, of in found.items()}
    trainings = _without_copies(_with_seeds(best, notes), notes)
    if not template:
        _require_apart(folder, trainings)
    notes += _left_out(logs, trainings)
    order = _in_order({it.reward for it in trainings}, baseline)
    return Sorted(tuple(sorted(trainings, key=lambda it: (order.index(it.reward), it.seed))), tuple(notes))


def require_several(folder: Path, found: Sorted) -> None:
    """Check that each reward has taught several trainings, or one reward all: mistaken names look like that.

    Args:
        folder: Where they lie.
        found: The trainings, sorted by names alone.

    Raises:
        UsageError: One taught a single one; says the flags that say it otherwise.
    """
    rewards = [it.reward for it in found.trainings]
    single = [name for name in found.rewards if rewards.count(name) < 2]
    if single and len(found.rewards) > 1:
        batches = [it for it in found.trainings if len(it.logs) > 1]
        paths = [(log.facts.path, log.facts.run) for it in batches or found.trainings for log in it.logs]
        raise question(
            list(dict.fromkeys(_name_of(folder, *it) for it in paths)),
            f"say that there is one training alone of {listed(single[:3])}{', ...' * (len(single) > 3)}, and chance "
            "cannot be told from one",
            _ways(folder, [it.path for it in batches])[::-1] if batches else None,
        )


def sort_files(
    folder: Path, files: Sequence[Path], template: str = "", baseline: str = "", *, is_asked: bool = True
) -> dict[str, list[Path]]:
    """The files of each reward, the baseline's first, by their names alone; see `sort_logs`."""
    names = {path: _name_of(folder, path) for path in files}
    named = sort_names(names.values(), template, is_asked=is_asked)
    found: dict[str, list[Path]] = {}
    for path, name in names.items():
        found.setdefault(named[name].reward or folder.resolve().name, []).append(path)
    return {name: found[name] for name in _in_order(found, baseline)}


def _without_evaluated(folder: Path, logs: Sequence[Log], notes: list[str]) -> Sequence[Log]:
    """The logs without what Monitor wrote of evaluations, which counts no steps of the training; a note tells it."""
    left = [log for log in logs if "seconds" in log and any(map(EVALUATED.fullmatch, _parts(folder, log.facts.path)))]
    if not left or len(left) == len(logs):
        return logs
    notes.append(
        f"Left out: {len(left)} of Monitor that are called evaluations, such as '{left[0].facts.path}'. They do not "
        "tell after how many steps of the training they were made"
    )
    return [log for log in logs if log not in left]


# Names


def _parts(folder: Path, path: Path) -> list[str]:
    """The folders below `folder` in which a log lies, and the name of its file without an ending."""
    below = (path.relative_to(folder) if path.is_relative_to(folder) else path).parts
    return [*below] if path.is_dir() else [*below[:-1], ENDING.sub("", path.name)]


def _name_of(folder: Path, path: Path, run: str = "") -> str:
    """The path below the folder without what says nothing, and what the file calls the training."""
    parts = _parts(folder, path)
    if not path.is_dir() and (parts[-1].lower() in PLAIN_FILES or path.name.startswith(EVENTS)):
        parts.pop()
    said = [part for part in parts if part.lower() not in PLAIN_FOLDERS]
    return "/".join(filter(None, [*said, run])) or folder.resolve().name


def _is_numbered(log: Log) -> bool:
    """Whether it is of Monitor, and its file is called 0, 1, 2, or 0.1, as a batch of environments calls its files."""
    name = _parts(log.facts.path.parent, log.facts.path)[-1]
    return "seconds" in log and not log.facts.run and NUMBERED.fullmatch(name) is not None


def _ways(folder: Path, places: Iterable[Path]) -> list[str]:
    """The templates by which each folder is one training, and by which each of its files is."""
    way = next(iter(templates_of([*dict.fromkeys(_name_of(folder, it) for it in places)])), "{reward}")
    return [way, f"{way.replace('{seed}', '*')}/{'*' if '{seed}' in way else '{seed}'}"]


def _batches(folder: Path, names: Mapping[Log, str], notes: list[str]) -> dict[Log, str]:
    """The numbered files of Monitor that are environments of one training, each with their folder's name.

    Raises:
        UsageError: Nobody can tell whether they are; says both flags.
    """
    beside: dict[Path, list[Log]] = {}
    for log in filter(_is_numbered, names):
        beside.setdefault(log.facts.path.parent, []).append(log)
    several = {place: of for place, of in beside.items() if len(_distinct(of)) > 1}
    together = {place: in_lockstep(of) for place, of in several.items()}
    known = {*together.values()} - {None}
    if None in together.values() and len(known) != 1:  # folders beside one another were written by one program
        why = "are of Monitor: of one training's environments, or of a training each? Their times do not tell"
        raise question([names[log] for of in several.values() for log in of], why, _ways(folder, several))
    batches = [place for place, is_one in together.items() if is_one or known == {True}]
    if batches:
        notes.append(
            f"The numbered files of a folder are read as environments of one training, as the "
            f"{len(several[batches[0]])} in '{batches[0]}': their episodes end in step. If each is a training, say "
            f"--sort '{_ways(folder, several)[1]}'"
        )
    return {log: _name_of(folder, place) for place in batches for log in several[place]}


def _named(folder: Path, names: Mapping[Log, str], template: str) -> dict[Log, Named]:
    """What each log, or its name, says: names are sorted among logs of the same kind.

    A log that says little is of the training that is called as it is, or as a folder in which it lies.
    """
    kinds: dict[tuple[bool, int, str], list[Log]] = {}
    for log in names:
        kinds.setdefault((log.facts.evaluation, UNITS.index(log.facts.unit), log.facts.format), []).append(log)
    order = sorted(kinds, key=lambda kind: (*kind[:2], -len(kinds[kind]), kind))
    found, above = dict[Log, Named](), dict[str, Named]()
    for kind in order:
        homes = {log: [*accumulate(names[log].split("/"), "{}/{}".format)] for log in kinds[kind]}
        named = {log: next((above[home] for home in of[::-1] if home in above), None) for log, of in homes.items()}
        alone = [log for log, of in named.items() if not of]
        is_asked = any(not log.facts.trained_with for log in alone)
        own = sort_names([names[log] for log in alone], template, is_asked=is_asked) if alone else {}
        for log, home in named.items():
            of, facts = home or own[names[log]], log.facts
            if not template:
                of = Named(facts.trained_with or of.reward, of.seed if facts.seed is None else facts.seed, of.place)
            found[log] = of._replace(reward=of.reward or folder.resolve().name)
        if not template and kind == order[0]:
            above = {names[log]: found[log] for log in alone}
    return found


# What belongs together


def _best_of(
    key: Key, of: Sequence[Log], names: Mapping[Log, str], *, is_told: bool
) -> tuple[tuple[Log, ...], Log | None]:
    """The log that tells a training best, of all of its logs, and the one of its evaluations.

    A log of success is better than one of returns alone, then the one of the finest unit is. Only files of Monitor can
    be of environments that one training steps together.

    Raises:
        UsageError: Two logs tell the same of the training; says the flags that tell them apart.
    """
    finest = sorted(of, key=lambda log: (UNITS.index(log.facts.unit), str(log.facts.path)))
    evaluation = next((log for log in finest if log.facts.evaluation), None)
    trained = [log for log in finest if not log.facts.evaluation]
    needs_success = evaluation is None or SUCCESS not in evaluation.measures
    first = min(trained or finest, key=lambda log: needs_success and SUCCESS not in log.measures).facts
    for kind in (first if evaluation is None else evaluation.facts), first:
        alike = [log for log in of if (log.facts.format, log.facts.evaluation) == (kind.format, kind.evaluation)]
        logs = _distinct(alike)
        is_batch = len({names[log] for log in alike}) == 1 and all(map(_is_numbered, logs))
        is_batch |= is_told and all("seconds" in log and log.facts.path.parent == first.path.parent for log in logs)
        if len(logs) > 1 and not is_batch:
            twice = names[logs[0]], names[logs[1]]
            rest = dict.fromkeys(it for it in names.values() if it not in twice)
            one = command_text("--leave-out", logs[1].facts.path)
            why = f"say that {key[0]} was trained with seed {key[1]}: {one} keeps one"
            raise question([twice[0], *rest, twice[1]], why, None if len({*twice}) > 1 else [])
    return tuple(logs), evaluation if trained else None


def _distinct(logs: Iterable[Log]) -> list[Log]:
    found: dict[str, Log] = {}
    for log in logs:
        found.setdefault(digest_of([log]) or str(log.facts.path), log)
    return list(found.values())


def _require_apart(folder: Path, trainings: Iterable[Training]) -> None:
    """Check that trainings of one reward are not environments of one, whatever their files are called.

    Raises:
        UsageError: Two are: says which, and the flag that says it otherwise.
    """
    of = [it for it in trainings if it.facts.started is not None and it.facts.unit == "episode"]
    of.sort(key=lambda it: (it.reward, it.facts.started))
    for first, second in pairwise(of):  # environments of one training are begun one after the other
        if first.reward == second.reward and in_lockstep([*first.logs, *second.logs]):
            paths = [log.facts.path for it in of for log in it.logs]
            raise question(
                [_name_of(folder, it) for it in paths],
                "say that each is a training, and their times that several are environments of one: their episodes "
                "end in step",
                [it.replace("{seed}", "*") for it in _ways(folder, [it.parent for it in paths])],
            )


def _with_seeds(best: Mapping[Key, tuple[tuple[Log, ...], Log | None]], notes: list[str]) -> list[Training]:
    """The trainings; a note tells how many tell no seed."""
    seeds = numbered([(reward, told) for reward, told, _ in best])
    found = [Training(reward, seed, *of) for ((reward, _, _), of), seed in zip(best.items(), seeds, strict=True)]
    untold = sum(told is None for _, told, _ in best)
    if untold and len(found) > len({it.reward for it in found}):
        notes.append(f"{untold} of {len(found)} trainings tell no seed: numbered in the order of their names")
    return found


def digest_of(logs: Iterable[Log]) -> str:
    """SHA-256 of the rows of a training; empty where they do not vary, so that equal ones would say nothing."""
    rows = [rows + str(len(log)).encode() for log in logs if (rows := _rows_of(log))]
    return hashlib.sha256(b"".join(rows)).hexdigest() if rows else ""


def _rows_of(log: Log) -> bytes:
    """The first numbers of a log, row by row; none where neither pay nor behaviour varies."""
    names = [name for name in sorted(log.names) if name.startswith((*TOLD, TIME, "length", "seconds"))]
    rows = next(log.pieces(names), Rows({}))
    varies = any(name.startswith(TOLD) and (of != of[:1]).any() for name, of in rows.columns.items())
    return f"{names}".encode() + np.column_stack([rows[name] for name in names]).tobytes() if varies else b""


def _without_copies(trainings: Sequence[Training], notes: list[str]) -> list[Training]:
    """Each training once, though its rows, or the first of them, may lie in several files; a note tells each copy."""
    begins = sorted((it.reward, _rows_of(it.logs[0]), -number) for number, it in enumerate(trainings))
    pairs = [*pairwise(begins), *pairwise(sorted(begins, key=lambda it: it[1]))]  # whatever begins so follows at once
    copies = set[Training]()
    for (reward, own, number), (other, longer, whole) in pairs:
        copy, is_equal, is_same = trainings[-number], longer == own, reward == other
        log = copy.logs[0]
        values = (len(np.unique(log[name])) for name in log.names if name.startswith(TOLD))
        if not own or copy in copies or not longer.startswith(own):
            continue
        if is_same if is_equal else max(values) >= FEWEST:
            copies.update([copy] * is_same)
            once = ": the training counts once" if is_same else f", though one is of {reward} and one of {other}"
            told = f"{copy.shown} is {'equal to' if is_equal else 'the beginning of'} {trainings[-whole].shown}"
            notes.append(told + once)
    return [it for it in trainings if it not in copies]


def _left_out(logs: Sequence[Log], trainings: Sequence[Training]) -> list[str]:
    """How many logs of each kind say less of a training than another one does."""
    told = {log for it in trainings for log in it.all_logs}
    kept = {log.facts.format for it in trainings for log in it.logs}
    kinds: dict[str, list[Log]] = {}
    for log in logs:
        if log not in told and log.facts.format not in kept:
            kinds.setdefault(log.facts.format, []).append(log)
    return [
        f"Left out: {len(of)} of {name}, such as '{of[0].facts.path}'. {listed(sorted(kept))} says more of the same "
        "trainings"
        for name, of in kinds.items()
    ]


def _in_order(rewards: Collection[str], baseline: str) -> list[str]:
    """The names of rewards, the baseline's first: the one that is told, or is called so."""
    names = sorted(rewards, key=lambda name: ("base" not in name.lower(), not name.lower().startswith("base"), name))
    if baseline and baseline not in names:
        told = ", ".join(sorted(names))
        raise UsageError(f"--baseline {baseline}: no training was taught by it. There are: {told}")
    first = baseline or names[0]
    return [first, *sorted({*names} - {first})]
