"""Sorts the logs of a folder into trainings: which reward taught each, with which seed, and which log tells it best."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from harness.errors import UsageError
from harness.eta.amounts import listed
from harness.log import Log, Unit
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS, TIME
from harness.results.logs.names import Named, in_lockstep, question, sort_by_template, sort_names, templates_of

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
        UsageError: Names can be read in two ways, two logs are of one reward and one seed, a name does not fit the
            template, or there is no such reward.
    """
    notes: list[str] = []
    logs = _without_evaluated(folder, logs, notes)
    names = [_name_of(folder, log.facts.path, log.facts.run) for log in logs]
    if all(map(NUMBERED.fullmatch, names)):  # of one reward, whose name is the folder's
        names = [f"{folder.resolve().name}/{name}" for name in names]
    places = names if template else _with_batches(folder, logs, names, notes)
    named = _named(folder, logs, places, template)
    found: dict[Key, list[tuple[Log, str]]] = {}
    for log, of, place in zip(logs, _at_home(folder, logs, named, template), places, strict=True):
        found.setdefault((of.reward, of.seed, of.place if of.seed is None else ""), []).append((log, place))
    best = {key: _best_of(key, of, is_told=bool(template)) for key, of in found.items()}
    trainings = _without_copies(_with_seeds(best, notes), notes)
    if not template:
        _require_apart(folder, trainings)
    notes += _left_out(logs, trainings)
    first = _baseline(baseline, dict.fromkeys(it.reward for it in trainings))
    ordered = sorted(trainings, key=lambda it: (it.reward != first, it.reward, it.seed))
    return Sorted(tuple(ordered), tuple(notes))


def require_several(folder: Path, found: Sorted) -> None:
    """Check that each reward has taught several trainings, or one reward all: mistaken names look like that.

    Args:
        folder: Where they lie.
        found: The trainings, sorted by names alone.

    Raises:
        UsageError: One taught a single one; says the flags that say it otherwise.
    """
    counts = {name: sum(it.reward == name for it in found.trainings) for name in found.rewards}
    single = [name for name, count in counts.items() if count < 2]
    if not single or len(counts) < 2:
        return
    more = f" and {len(single) - 3} more" if len(single) > 3 else ""
    alone = f"There is one training alone of {listed(single[:3])}{more}, and chance cannot be told from one"
    batch = next((it for it in found.trainings if it.reward in single and len(it.logs) > 1), None)
    if batch:
        way, each = _ways(folder, [it.path for it in found.trainings if len(it.logs) > 1])
        raise UsageError(
            f"{alone}: the {len(batch.logs)} files in {batch.shown} are environments of one training, as their "
            f"episodes end in step. --sort '{each}' says that each file is a training, --sort '{way}' that they are not"
        )
    names = dict.fromkeys(_name_of(folder, it.path, it.logs[0].facts.run) for it in found.trainings)
    raise question([*names], f"say that these are {found.sentence}. {alone}")


def sort_files(
    folder: Path, files: Sequence[Path], template: str = "", baseline: str = "", *, is_asked: bool = True
) -> dict[str, list[Path]]:
    """The files of each reward, the baseline's first, by their names alone; see `sort_logs`."""
    found: dict[str, list[Path]] = {}
    named = _sorted(folder, [_name_of(folder, it) for it in files], template, is_asked=is_asked)
    for path, of in zip(files, named, strict=True):
        found.setdefault(of.reward, []).append(path)
    first = _baseline(baseline, found)
    return {name: found[name] for name in sorted(found, key=lambda name: (name != first, name))}


def _sorted(folder: Path, names: Sequence[str], template: str, *, is_asked: bool) -> list[Named]:
    """What each name says; where none says what the reward is, the folder has its name."""
    different = list(dict.fromkeys(names))
    found = sort_by_template(template, different) if template else sort_names(different, is_asked=is_asked)
    of = dict(zip(different, found, strict=True))
    return [of[name]._replace(reward=of[name].reward or folder.resolve().name) for name in names]


def _kind(log: Log) -> tuple[str, bool]:
    return log.facts.format, log.facts.evaluation


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
    below = path.relative_to(folder) if path.is_relative_to(folder) else path
    return [*below.parts] if path.is_dir() else [*below.parent.parts, _stem(path.name)]


def _name_of(folder: Path, path: Path, run: str = "") -> str:
    """The path below the folder without what says nothing, and what the file calls the training."""
    parts = _parts(folder, path)
    if not path.is_dir() and (parts[-1].lower() in PLAIN_FILES or parts[-1].startswith(EVENTS)):
        parts.pop()
    said = [part for part in parts if part.lower() not in PLAIN_FOLDERS]
    return "/".join(filter(None, [*said, run])) or folder.resolve().name


def _stem(name: str) -> str:
    ending = next((it for it in ENDINGS if name.lower().endswith(it)), "")
    return name[: -len(ending)] if ending else name if name.startswith(EVENTS) else Path(name).stem


def _ways(folder: Path, places: Iterable[Path]) -> tuple[str, str]:
    """The templates by which each folder is one training, and by which each of its files is."""
    way = templates_of([*dict.fromkeys(_name_of(folder, it) for it in places)])[0]
    return way, f"{way.replace('{seed}', '*')}/{'*' if '{seed}' in way else '{seed}'}"


def _with_batches(folder: Path, logs: Sequence[Log], names: Sequence[str], notes: list[str]) -> list[str]:
    """The names; of numbered files of Monitor that are environments of one training, their folder's name.

    Raises:
        UsageError: Nobody can tell whether they are; says both flags.
    """
    beside: dict[Path, list[Log]] = {}
    for log in logs:
        if "seconds" in log and not log.facts.run and NUMBERED.fullmatch(_stem(log.facts.path.name)):
            beside.setdefault(log.facts.path.parent, []).append(log)
    several = {place: of for place, of in beside.items() if len(_distinct(of)) > 1}
    together = {place: in_lockstep(of) for place, of in several.items()}
    known = {*together.values()} - {None}
    batches = [place for place, is_one in together.items() if is_one or known == {True}]
    doubtful = [place for place, is_one in together.items() if is_one is None and len(known) != 1]
    if doubtful:  # folders beside one another were written by one program
        way, each = _ways(folder, several)
        count = len(several[doubtful[0]])
        raise UsageError(
            f"'{doubtful[0]}' holds {count} numbered files of Monitor: of one training's environments, or of {count} "
            f"trainings? Their times do not tell. Say --sort '{way}' if a folder is one training, --sort '{each}' if "
            "each file is one"
        )
    if batches:
        notes.append(
            f"The numbered files of a folder are read as environments of one training, as the "
            f"{len(several[batches[0]])} in '{batches[0]}': their episodes end in step. If each is a training, say "
            f"--sort '{_ways(folder, several)[1]}'"
        )
    members = {id(log): place for place in batches for log in several[place]}
    return [
        _name_of(folder, members[id(log)]) if id(log) in members else name
        for log, name in zip(logs, names, strict=True)
    ]


def _named(folder: Path, logs: Sequence[Log], names: Sequence[str], template: str) -> list[Named]:
    """What each log, or its name, says: names are sorted among logs of the same kind."""
    found: dict[int, Named] = {}
    for kind in dict.fromkeys(map(_kind, logs)):
        numbers = [number for number, log in enumerate(logs) if _kind(log) == kind]
        is_asked = any(not logs[number].facts.trained_with for number in numbers)
        of = _sorted(folder, [names[number] for number in numbers], template, is_asked=is_asked)
        found |= dict(zip(numbers, of, strict=True))
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


def _at_home(folder: Path, logs: Sequence[Log], named: Sequence[Named], template: str) -> list[Named]:
    """The training of each log: of one that says little, the one that lies alone in its folder, or in one above it."""
    kinds = {_kind(log): log for log in logs}
    counts = {kind: sum(_kind(log) == kind for log in logs) for kind in kinds}
    most = min(kinds, key=lambda kind: (kind[1], UNITS.index(kinds[kind].facts.unit), -counts[kind], kind[0]))
    homes = [log.facts.path if log.facts.path.is_dir() else log.facts.path.parent for log in logs]
    for number, place in enumerate(homes):
        plain = [it for it in (place, *place.parents) if it == folder or it.name.lower() not in PLAIN_FOLDERS]
        homes[number] = plain[0]
    living: dict[Path, set[Named]] = {}
    for log, of, home in zip(logs, named, homes, strict=True):
        if _kind(log) == most:
            living.setdefault(home, set()).add(of)
    found = []
    for log, of, home in zip(logs, named, homes, strict=True):
        above = [it for it in (home, *home.parents) if it in living and len(living[it]) == 1]
        is_own = template or _kind(log) == most or not above or not above[0].is_relative_to(folder)
        found.append(of if is_own else next(iter(living[above[0]])))
    return found


def _best_of(key: Key, of: Sequence[tuple[Log, str]], *, is_told: bool) -> tuple[tuple[Log, ...], Log | None]:
    """The log that tells a training best, of all of its logs, and the one of its evaluations.

    A log of success is better than one of returns alone, then the one of the finest unit is. Only files of Monitor can
    be of environments that one training steps together.
    """

    def fineness(log: Log) -> tuple[int, str]:
        return UNITS.index(log.facts.unit), str(log.facts.path)

    evaluations = sorted((log for log, _ in of if log.facts.evaluation), key=fineness)
    evaluation = evaluations[0] if evaluations else None
    trained = [log for log, _ in of if not log.facts.evaluation]
    has_success = evaluation is not None and SUCCESS in evaluation.measures
    first, *_ = sorted(
        trained or evaluations, key=lambda log: (not has_success and SUCCESS not in log.measures, *fineness(log))
    )
    best = [(log, name) for log, name in of if _kind(log) == _kind(first)]
    logs = _distinct(log for log, _ in best)
    is_batch = len({name for _, name in best}) == 1 and all(
        NUMBERED.fullmatch(_stem(it.facts.path.name)) for it in logs
    )
    can_be = all("seconds" in log for log in logs) and len({log.facts.path.parent for log in logs}) == 1
    if not (can_be and (is_batch or is_told)):
        logs = [_joined(key, logs)]
    return tuple(logs), evaluation if trained else None


def _joined(key: Key, logs: Sequence[Log]) -> Log:
    """The one log of a training; of several that tell other columns at the same times, all of their columns.

    Raises:
        UsageError: Two logs tell the same of one training.
    """
    whole = logs[0]
    for log in logs[1:]:
        new = {name: log[name] for name in (*log.names,) if name.startswith((REWARD, BEHAVIOUR))}
        if any(name in whole for name in new) or not np.array_equal(whole[TIME], log[TIME]):
            raise UsageError(
                f"'{whole.facts.path}' and '{log.facts.path}' were both trained with {key[0]} and seed {key[1]}: keep "
                "one, or say how names are made, such as --sort '{reward}/{seed}'"
            )
        whole = whole.add(new)
    return whole


def _distinct(logs: Iterable[Log]) -> list[Log]:
    return list({digest_of([log]) or str(log.facts.path): log for log in [*logs][::-1]}.values())[::-1]


def _require_apart(folder: Path, trainings: Iterable[Training]) -> None:
    """Check that trainings of one reward are not environments of one, whatever their files are called.

    Raises:
        UsageError: Two are: says which, and the flag that says it otherwise.
    """
    begun = [(it.logs[0].facts.started, it) for it in trainings if it.logs[0].facts.unit == "episode"]
    in_order = sorted(
        (it.reward, started, number, it) for number, (started, it) in enumerate(begun) if started is not None
    )
    for (reward, *_, first), (other, *_, second) in pairwise(in_order):
        if reward == other and in_lockstep([*first.logs, *second.logs]):  # environments are begun one after the other
            way, each = _ways(folder, [log.facts.path.parent for _, it in begun for log in it.logs])
            raise UsageError(
                f"{first.shown} and {second.shown} look like two trainings of {reward} by their names, and like two "
                f"environments of one by their times: their episodes end in step. --sort '{way}' says that a folder is "
                f"one, --sort '{each}' that each file is"
            )


def _with_seeds(best: Mapping[Key, tuple[tuple[Log, ...], Log | None]], notes: list[str]) -> list[Training]:
    """Whoever has no seed gets the lowest number that is free."""
    taken = {(reward, seed) for reward, seed, _ in best}
    found = []
    for (reward, told, _), (logs, evaluation) in best.items():
        seed = next(it for it in range(len(best)) if (reward, it) not in taken) if told is None else told
        taken.add((reward, seed))
        found.append(Training(reward, seed, logs, evaluation))
    numbered = sum(told is None for _, told, _ in best)
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


def _without_copies(trainings: Sequence[Training], notes: list[str]) -> list[Training]:
    """Each training once, though its rows, or the first of them, may lie in several files; a note tells each copy."""
    alike: dict[tuple[bytes, ...], list[Training]] = {}
    copies = []
    for training in sorted(trainings, key=lambda it: -sum(map(len, it.logs))):
        names = sorted(training.logs[0].names)
        begin = next(training.logs[0].pieces(names, FEWEST), None)
        others = alike.setdefault(tuple(begin[name].tobytes() for name in names) if begin else (), [])
        whole = [it for it in others if _is_part(training, it)]
        same = next((it for it in whole if it.reward == training.reward), None)
        if same:
            copies.append(training)
            equal = "equal to" if len(same.logs[0]) == len(training.logs[0]) else "the beginning of"
            notes.append(f"{training.shown} is {equal} {same.shown}: the training counts once")
        elif whole and len(whole[0].logs[0]) > len(training.logs[0]):
            notes.append(
                f"{training.shown} of {training.reward} is the beginning of {whole[0].shown} of {whole[0].reward}"
            )
        others.append(training)
    return [it for it in trainings if it not in copies]


def _is_part(training: Training, whole: Training) -> bool:
    """Whether a training's rows are all rows of another one, or its first; they have to vary to say so."""
    values = 0
    for log, other in zip(training.logs, whole.logs, strict=False):
        names = sorted(log.names)
        if len(training.logs) != len(whole.logs) or names != sorted(other.names):
            return False
        for piece, longer in zip(log.pieces(names), other.pieces(names), strict=False):
            for name in names:
                own = piece[name]
                if own.tobytes() != longer[name][: len(own)].tobytes():
                    return False
                if name.startswith((REWARD, BEHAVIOUR)):
                    values = max(values, len(np.unique(own)))
    return values >= (FEWEST if sum(map(len, training.logs)) < sum(map(len, whole.logs)) else 2)


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
