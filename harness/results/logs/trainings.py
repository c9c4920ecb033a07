"""Sorts the logs of a folder into trainings: which reward taught each, with which seed, and which log tells it best."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.errors import UsageError
from harness.eta.amounts import listed
from harness.log import Log, Unit
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS
from harness.results.logs.names import Named, Templates, in_lockstep, sort_by_template, sort_names, templates_of

UNITS: tuple[Unit, ...] = ("step", "episode", "point")
"""The finest first."""
PLAIN_FILES = ("monitor", "evaluations", "progress", "result", "results", "metrics", "episodes", "log", "data")
PLAIN_FOLDERS = ("eval", "evaluation", "evaluations", "tb", "tensorboard", "log", "logs", "monitor", "runs", "train")
"""Names that programs give to what belongs to any training: they say nothing of it."""
EVENTS = "events.out.tfevents"
ENDINGS = (".monitor.csv", ".csv", ".npz", ".json", ".jsonl", ".parquet", ".hdf5", ".h5")
NUMBERED = re.compile("[0-9]+([.][0-9]+)*")
"""Names of files which a batch of environments writes: a number, or one of a process and one of its environment."""
EVALUATED = re.compile("eval(uation)?s?([-_](env|logs?|monitor))?", re.IGNORECASE)
"""Names of files and folders of an environment in which policies were evaluated."""


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
    def path(self) -> Path:
        """The file or the folder of its log; of several files their folder."""
        return self.logs[0].facts.path if len(self.logs) == 1 else self.logs[0].facts.path.parent

    @property
    def place(self) -> Path:
        """The same with what a file that holds several calls it."""
        return self.path / self.logs[0].facts.run

    @property
    def shown(self) -> str:
        """The path in words, with what the file calls the training."""
        run = self.logs[0].facts.run
        return f"'{self.path}'{f' ({run})' if run else ''}"

    @property
    def is_evaluated_alone(self) -> bool:
        """Whether nothing is known of it but evaluations."""
        return self.logs[0].facts.evaluation

    @property
    def all_logs(self) -> tuple[Log, ...]:
        """Those of the training and that of its evaluations."""
        return self.logs if self.evaluation is None else (*self.logs, self.evaluation)

    @property
    def evaluated(self) -> Log | None:
        """What policies did without being trained; what somebody else says of it comes first."""
        return self.logs[0] if self.evaluation is None and self.is_evaluated_alone else self.evaluation


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
        UsageError: Two logs are of one reward and one seed, a name does not fit the template, or there is no such
            reward.
    """
    logs, notes = _without_evaluated(folder, logs)
    names = _names_of(folder, logs, notes if not template else None)
    named = _named(folder, logs, names, template)
    primary = _primary(logs)
    homes = _homes(folder, [(log, of) for log, of in zip(logs, named, strict=True) if _kind(log) == primary])
    found: dict[tuple[str, int | None, str], list[Log]] = {}
    for log, of in zip(logs, named, strict=True):
        home = of if _kind(log) == primary or template else _home_of(folder, log, homes) or of
        key = (home.reward, home.seed, home.place if home.seed is None else "")
        found.setdefault(key, []).append(log)
    best = {key: _best_of(key, of, names, logs, is_told=bool(template)) for key, of in found.items()}
    trainings, copies = _without_copies(_with_seeds(best, notes))
    if not template:
        _require_apart(trainings)
    notes += [*copies, *_left_out(logs, trainings)]
    first = _baseline(baseline, dict.fromkeys(it.reward for it in trainings))
    ordered = sorted(trainings, key=lambda it: (it.reward != first, it.reward, it.seed))
    return Sorted(tuple(ordered), tuple(notes))


def sort_files(folder: Path, files: Sequence[Path], template: str = "", baseline: str = "") -> dict[str, list[Path]]:
    """The files of each reward, the baseline's first, by their names alone; see `sort_logs`."""
    names = [_name_of(folder, path, "") for path in files]
    found: dict[str, list[Path]] = {}
    for path, of in zip(files, _sorted(folder, names, template), strict=True):
        found.setdefault(of.reward, []).append(path)
    first = _baseline(baseline, found)
    return {name: found[name] for name in sorted(found, key=lambda name: (name != first, name))}


def _sorted(folder: Path, names: Sequence[str], template: str) -> list[Named]:
    """What each name says; where none says what the reward is, the folder has its name."""
    different = list(dict.fromkeys(names))
    of = dict(zip(different, sort_by_template(template, different) if template else sort_names(different), strict=True))
    return [of[name]._replace(reward=of[name].reward or folder.resolve().name) for name in names]


def _kind(log: Log) -> tuple[str, bool]:
    return log.facts.format, log.facts.evaluation


def _primary(logs: Sequence[Log]) -> tuple[str, bool]:
    """The kind of log that the most is told by: no evaluation, of the finest unit, and of most trainings."""
    kinds = {_kind(log): log for log in logs}
    counts = {kind: sum(_kind(log) == kind for log in logs) for kind in kinds}
    return min(kinds, key=lambda kind: (kind[1], UNITS.index(kinds[kind].facts.unit), -counts[kind], kind[0]))


def _without_evaluated(folder: Path, logs: Sequence[Log]) -> tuple[Sequence[Log], list[str]]:
    """The logs without what Monitor wrote of evaluations, which counts no steps of the training; and a line of them."""
    evaluated = [log for log in logs if "seconds" in log and any(map(EVALUATED.fullmatch, _parts(folder, log)))]
    if not evaluated or len(evaluated) == len(logs):
        return logs, []
    left = {id(log) for log in evaluated}
    told = (
        f"Left out: {len(evaluated)} of Monitor that are called evaluations, such as '{evaluated[0].facts.path}'. They "
        "do not tell after how many steps of the training they were made"
    )
    return [log for log in logs if id(log) not in left], [told]


def _parts(folder: Path, log: Log) -> list[str]:
    path = log.facts.path
    below = path.relative_to(folder) if path.is_relative_to(folder) else path
    return [*below.parent.parts, _stem(path.name)]


# Names


def _names_of(folder: Path, logs: Sequence[Log], notes: list[str] | None) -> dict[int, str]:
    """By position of the log, the name that says its reward and seed.

    Args:
        folder: Where they lie.
        logs: All of them.
        notes: Takes how numbered files are read; None if files of one folder are not looked at.
    """
    names = {number: _name_of(folder, log.facts.path, log.facts.run) for number, log in enumerate(logs)}
    if all(map(NUMBERED.fullmatch, names.values())):  # of one reward, whose name is the folder's
        names = {number: f"{folder.resolve().name}/{name}" for number, name in names.items()}
    if notes is None:
        return names
    beside: dict[Path, list[int]] = {}
    for number, log in enumerate(logs):
        if _may_be_of_a_batch(log):
            beside.setdefault(log.facts.path.parent, []).append(number)
    several = {place: of for place, of in beside.items() if len(_distinct(logs[it] for it in of)) > 1}
    ways = dict(zip(several, templates_of([_place_name(folder, place) for place in several]), strict=True))
    together = {place: in_lockstep(logs[it] for it in of) for place, of in several.items()}
    known = {it for it in together.values() if it is not None}
    for place, is_one in together.items():
        if is_one is None and len(known) != 1:  # folders beside one another were written by one program
            raise UsageError(_doubt_told(place, len(several[place]), ways[place]))
    batches = {place: of for place, of in several.items() if together[place] or known == {True}}
    for place, of in batches.items():
        names |= dict.fromkeys(of, _place_name(folder, place))
    if batches:
        place, of = next(iter(batches.items()))
        notes.append(
            f"The numbered files of a folder are read as environments of one training, as the {len(of)} in '{place}': "
            f"their episodes end in step. If each is a training, say --sort '{ways[place].each_file}'"
        )
    return names


def _doubt_told(place: Path, count: int, ways: Templates) -> str:
    """What to say of numbered files that may be one training or several."""
    return (
        f"'{place}' holds {count} numbered files of Monitor: of one training's environments, or of {count} trainings? "
        f"Their times do not tell. Say --sort '{ways.folder}' if a folder is one training, --sort '{ways.each_file}' "
        "if each file is one"
    )


def _may_be_of_a_batch(log: Log) -> bool:
    """Whether it is of Monitor, and its file is called 0, 1, 2, or 0.1, as a batch of environments calls its files."""
    is_trained = log.facts.unit == "episode" and not log.facts.evaluation and not log.facts.run
    return is_trained and "seconds" in log and _is_numbered(log)


def _is_numbered(log: Log) -> bool:
    return NUMBERED.fullmatch(_stem(log.facts.path.name)) is not None


def _name_of(folder: Path, path: Path, run: str) -> str:
    """The path below the folder without what says nothing, and what the file calls the training."""
    place = path if path.is_dir() else path.parent
    parts = [] if path.is_dir() else [_stem(path.name)]
    if parts and (parts[0].lower() in PLAIN_FILES or parts[0].startswith(EVENTS)):
        parts = []
    inside = _place_name(folder, place, is_whole=not (parts or run))
    return "/".join(filter(None, [inside, *parts, run]))


def _place_name(folder: Path, place: Path, *, is_whole: bool = True) -> str:
    """The name of a folder below another one; that folder's own name if nothing else says anything."""
    below = place.relative_to(folder).parts if place.is_relative_to(folder) else place.parts
    said = [part for part in below if part.lower() not in PLAIN_FOLDERS]
    return "/".join(said) or (folder.resolve().name if is_whole else "")


def _stem(name: str) -> str:
    ending = next((it for it in ENDINGS if name.lower().endswith(it)), "")
    return name[: -len(ending)] if ending else name if name.startswith(EVENTS) else Path(name).stem


def _named(folder: Path, logs: Sequence[Log], names: Mapping[int, str], template: str) -> list[Named]:
    """What each log, or its name, says: names are sorted among logs of the same kind."""
    found: dict[int, Named] = {}
    for kind in dict.fromkeys(map(_kind, logs)):
        numbers = [number for number, log in enumerate(logs) if _kind(log) == kind]
        found |= dict(zip(numbers, _sorted(folder, [names[number] for number in numbers], template), strict=True))
    if template:
        return [found[number] for number in range(len(logs))]
    return [
        found[number]._replace(
            reward=log.facts.trained_with or found[number].reward,
            seed=found[number].seed if log.facts.seed is None else log.facts.seed,
        )
        for number, log in enumerate(logs)
    ]


# What belongs together


def _homes(folder: Path, logs: Iterable[tuple[Log, Named]]) -> dict[Path, Named]:
    """Folders in which one training alone lies."""
    found: dict[Path, dict[Named, None]] = {}
    for log, of in logs:
        found.setdefault(_home(folder, log), {})[of] = None
    return {place: next(iter(of)) for place, of in found.items() if len(of) == 1}


def _home(folder: Path, log: Log) -> Path:
    path = log.facts.path
    place = path if path.is_dir() else path.parent
    while place.name.lower() in PLAIN_FOLDERS and place != folder:
        place = place.parent
    return place


def _home_of(folder: Path, log: Log, homes: Mapping[Path, Named]) -> Named | None:
    """The training in whose folder, or in a folder of it, a log lies."""
    place = _home(folder, log)
    while place not in homes and place not in (folder, place.parent):
        place = place.parent
    return homes.get(place)


def _best_of(
    key: tuple[str, int | None, str], of: Sequence[Log], names: Mapping[int, str], logs: Sequence[Log], *, is_told: bool
) -> tuple[tuple[Log, ...], Log | None]:
    """The log that tells a training best, of all of its logs, and the one of its evaluations.

    A log of success is better than one of returns alone, then the one of the finest unit is.
    """
    evaluations = sorted((log for log in of if log.facts.evaluation), key=_fineness)
    evaluation = evaluations[0] if evaluations else None
    has_success = evaluation is not None and SUCCESS in evaluation.measures
    kinds: dict[tuple[str, bool], list[Log]] = {}
    for log in of:
        kinds.setdefault(_kind(log), []).append(log)
    trained = [some for kind, some in kinds.items() if not kind[1]]
    if not trained:
        _require_one(key, [log for log in evaluations if _kind(log) == _kind(evaluations[0])])
        return (evaluations[0],), None
    best = min(trained, key=lambda some: (not has_success and SUCCESS not in some[0].measures, *_fineness(some[0])))
    numbers = {id(log): number for number, log in enumerate(logs)}
    is_batch = len({names[numbers[id(log)]] for log in best}) == 1 and all(map(_is_numbered, best))
    if not (is_told and len({log.facts.path.parent for log in best}) == 1) and not is_batch:
        _require_one(key, best)
    return tuple(_distinct(best)), evaluation


def _fineness(log: Log) -> tuple[int, str]:
    return UNITS.index(log.facts.unit), str(log.facts.path)


def _require_one(key: tuple[str, int | None, str], logs: Sequence[Log]) -> None:
    first, *others = _distinct(logs)
    if others:
        reward, seed, _ = key
        raise UsageError(
            f"'{first.facts.path}' and '{others[0].facts.path}' were both trained with {reward} and seed {seed}: keep "
            "one, or say how names are made, such as --sort '{reward}/{seed}'"
        )


def _distinct(logs: Iterable[Log]) -> list[Log]:
    found: dict[str, Log] = {}
    for log in logs:
        found.setdefault(digest_of([log]) or str(log.facts.path), log)
    return list(found.values())


def _require_apart(trainings: Iterable[Training]) -> None:
    """Check that trainings of one reward are not environments of one, whatever their files are called.

    Raises:
        UsageError: Two are: says which, and the flag that says it otherwise.
    """
    of: dict[str, list[tuple[float, Training]]] = {}
    for training in trainings:
        started = training.logs[0].facts.started
        if started is not None and training.logs[0].facts.unit == "episode":
            of.setdefault(training.reward, []).append((started, training))
    for reward, some in of.items():
        in_order = [training for _, training in sorted(some, key=lambda it: it[0])]
        for first, second in pairwise(in_order):  # environments of one training are begun one after the other
            if in_lockstep([*first.logs, *second.logs]):
                raise UsageError(
                    f"{first.shown} and {second.shown} look like two trainings of {reward} by their names, and like "
                    "two environments of one by their times: their episodes end in step. --sort '{reward}' says that a "
                    "folder is one, --sort '{reward}/*' that each file is"
                )


def _with_seeds(
    best: Mapping[tuple[str, int | None, str], tuple[tuple[Log, ...], Log | None]], notes: list[str]
) -> list[Training]:
    """Whoever has no seed gets the lowest number that is free."""
    taken: dict[str, set[int]] = {}
    for reward, seed, _ in best:
        taken.setdefault(reward, set()).update([] if seed is None else [seed])
    found, numbered = [], 0
    for (reward, told, _), (logs, evaluation) in best.items():
        numbered += told is None
        seed = next(free for free in range(len(best)) if free not in taken[reward]) if told is None else told
        taken[reward].add(seed)
        found.append(Training(reward, seed, logs, evaluation))
    if numbered and len(found) > len({it.reward for it in found}):
        notes.append(f"{numbered} of {len(found)} trainings tell no seed: numbered in the order of their names")
    return found


def digest_of(logs: Sequence[Log]) -> str:
    """SHA-256 of all numbers of a training; empty where they do not vary, so that equal ones would say nothing."""
    digest, varies = hashlib.sha256(), False
    for piece in (piece for log in logs for piece in log.pieces(log.names)):
        for name in sorted(piece.columns):
            values = np.ascontiguousarray(piece[name])
            varies = varies or (name.startswith((REWARD, BEHAVIOUR)) and bool((values != values[:1]).any()))
            digest.update(f"{name}\0{len(values)}\0".encode())
            digest.update(values.data)
    return digest.hexdigest() if varies else ""


def _without_copies(trainings: Sequence[Training]) -> tuple[list[Training], list[str]]:
    """Each training once, though its rows may lie in several files; and a line for each copy."""
    found: dict[tuple[str, str], Training] = {}
    notes: list[str] = []
    for training in trainings:
        digest = digest_of(training.logs)
        first = found.setdefault((training.reward, digest or training.shown), training)
        if first is not training:
            notes.append(f"{training.shown} is equal to {first.shown}: the training counts once")
    return list(found.values()), notes


def _left_out(logs: Sequence[Log], trainings: Sequence[Training]) -> list[str]:
    """How many logs of each kind say less of a training than another one does."""
    told = {id(log) for it in trainings for log in it.all_logs}
    kept = {log.facts.format for it in trainings for log in it.logs}
    kinds: dict[str, list[Log]] = {}
    for log in logs:
        if id(log) not in told and log.facts.format not in kept:
            kinds.setdefault(log.facts.format, []).append(log)
    return [
        f"Left out: {len(of)} of {name}, such as '{of[0].facts.path}'. {listed(sorted(kept))} says more of the same "
        "trainings"
        for name, of in kinds.items()
    ]


def _baseline(given: str, rewards: Iterable[str]) -> str:
    names = sorted(rewards)
    if given:
        if given not in names:
            raise UsageError(f"--baseline {given}: no training was taught by it. There are: {', '.join(names)}")
        return given
    called = [name for name in names if "base" in name.lower()]
    return min(called, key=lambda name: (not name.lower().startswith("base"), name), default=names[0])


def with_reward(logs: Iterable[Log], reward: str) -> list[Log]:
    """The same logs, of which the user says what taught them."""
    return [replace(log, facts=replace(log.facts, trained_with=reward)) for log in logs]
