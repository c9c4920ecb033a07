"""Finds the reward and the seed of trainings in the names of their files and folders, ``PPO_base_1``, ``prop/seed=3``.

The number that differs is the seed; what else differs is the reward. Nothing is read but names, and when episodes
ended: that tells the files of one training's environments from those of several trainings.
"""

import re
from collections.abc import Iterable, Sequence
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.log import Log

_DAY, _HOUR = "20[0-9]{2}[-_]?[01][0-9][-_]?[0-3][0-9]", "[0-2][0-9][-_:h]?[0-5][0-9](?:[-_:m]?[0-9]{2})?"
_CLOCK = re.compile(rf"(?<![0-9])(?:1[0-9]{{9}}(?:\.[0-9]+)?|{_DAY}(?:[-_T ]?{_HOUR})?)(?![0-9])")
"""Unix seconds since 2001, and dates with or without a time of the day: when somebody trained, never a seed."""
_NUMBER = re.compile(
    r"(?<![0-9.])(?P<word>[A-Za-z]*)(?P<between>[-_=. ]?)(?P<digits>[0-9]{1,9})(?![0-9A-Za-z]|\.[0-9])"
)
_SEED = ("seed", "s", "rng")
_RUN = ("run", "rep", "repeat", "replicate", "trial")
_VERSION = ("v", "version", "reward", "r", "k")
"""Words before a number: it is the seed; it is the seed where no other is told; it names a variant of a reward."""
_SEPARATORS = re.compile(r"[-_=,. /]+")
_WORDS = re.compile(r"[^-_=,. /]+")


class Named(NamedTuple):
    """What a name says of a training."""

    reward: str
    """What differs from the names of other rewards; empty where nothing does."""
    seed: int | None
    """None where no number can be one."""
    place: str
    """The part of the name that says it: the same of all that belongs to one training."""


class Templates(NamedTuple):
    """How a user says what the numbered files in a folder are; see `sort_by_template`."""

    folder: str
    """They are one training."""
    each_file: str
    """Each of them is one."""


class _Number(NamedTuple):
    word: str
    begin: int
    """Where the word before it begins, if that only says that it is a seed; else where the digits do."""
    end: int
    value: int


class _Name(NamedTuple):
    text: str
    numbers: tuple[_Number, ...]

    @property
    def skeleton(self) -> str:
        """The same text for all names that differ in numbers alone."""
        return self._without(self.numbers, "#")

    def without(self, number: _Number | None) -> str:
        """The text without the seed and the word that announces it."""
        return self._without([number] if number else [], "")

    def _without(self, numbers: Sequence[_Number], mark: str) -> str:
        text = self.text
        for number in reversed(numbers):
            text = text[: number.begin] + mark + text[number.end :]
        return text


def sort_names(names: Sequence[str]) -> list[Named]:
    """The reward and the seed of each training, by the names of all of them.

    A number behind ``seed`` or ``run`` is the seed. Otherwise it is the last number that differs between names which
    differ in numbers alone. Versions (``v1``), decimal numbers, dates and Unix times are none.

    Args:
        names: Paths below the folder, without endings of files; each once.
    """
    read = [_read(name) for name in names]
    alike: dict[str, list[_Name]] = {}
    for name in read:
        alike.setdefault(name.skeleton, []).append(name)
    seeds = [_seed_in(name, alike[name.skeleton]) for name in read]
    labels = labels_of([name.without(seed) for name, seed in zip(read, seeds, strict=True)])
    return [
        Named(label, None if seed is None else seed.value, name)
        for label, seed, name in zip(labels, seeds, names, strict=True)
    ]


def labels_of(texts: Sequence[str]) -> list[str]:
    """What differs between texts, by whole words: each without the words that all begin with, or end with.

    Where nothing, or only a number, would be left of some, all keep more words at the beginning.
    """
    different = list(dict.fromkeys(texts))
    if len(different) == 1:
        return [_last_part(texts[0])] * len(texts)
    words = [_WORDS.findall(text) for text in different]
    numbers = sum(1 for _ in takewhile(str.isdecimal, _shared_at_the_end(words)))
    words = [it[: len(it) - numbers] for it in words]
    shortest = min(map(len, words))
    begin = min(_shared(words), max(0, shortest - 1))
    end = min(len(_shared_at_the_end(words)), max(0, shortest - begin - 1)) + numbers
    while begin and any(_cut(text, begin, end).isdecimal() for text in different):
        begin -= 1
    return [_cut(text, begin, end) for text in texts]


def templates_of(places: Sequence[str]) -> list[Templates]:
    """For folders with such names, the template by which each is one training, and the one by which each file is.

    Args:
        places: Paths below the folder that is looked at; each once.
    """
    return [_templates(named) for named in sort_names(places)] if places else []


def _templates(named: Named) -> Templates:
    before, _, after = named.place.rpartition(named.reward) if named.reward else ("", "", "")
    text = f"{before}{{reward}}{after}" if before or after or named.reward == named.place else "{reward}"
    if named.seed is not None:
        text = re.sub(rf"(?<![0-9])0*{named.seed}(?![0-9])(?!.*[0-9])", "{seed}", text)
    folder = "/".join(part if "{" in part else "*" for part in text.split("/"))
    return Templates(folder, f"{folder.replace('{seed}', '*')}/{'*' if '{seed}' in folder else '{seed}'}")


def sort_by_template(template: str, names: Sequence[str]) -> list[Named]:
    """The same where the user says how names are made: ``{reward}/{seed}``, ``*_{reward}_s{seed}``.

    ``*`` stands for anything within a folder's or a file's name. What the template fits is one training: ``{reward}``
    says that all files of a folder are one, ``{reward}/*`` that each file is one. Without ``{seed}`` they have none.

    Raises:
        UsageError: It has no ``{reward}``, or a name is not made so.
    """
    if template.count("{reward}") != 1 or template.count("{seed}") > 1:
        raise UsageError(f"--sort '{template}' needs {{reward}} once, and {{seed}} at most once: '{{reward}}/{{seed}}'")
    pattern = re.escape(template)
    for mark, meaning in ((r"\{reward\}", "(?P<reward>[^/]+?)"), (r"\{seed\}", "(?P<seed>[0-9]{1,9})")):
        pattern = pattern.replace(mark, meaning)
    whole = re.compile(f"(?P<place>(?:.*?/)??{pattern.replace(re.escape('*'), '[^/]*?')})(?:[.][^/]*)?(?:/.*)?")
    found = []
    for name in names:
        match = whole.fullmatch(name)
        if match is None:
            raise UsageError(f"--sort '{template}' does not fit '{name}', which lies below the folder")
        told = match.groupdict()
        found.append(Named(told["reward"], int(told["seed"]) if "seed" in told else None, told["place"]))
    return found


def _read(text: str) -> _Name:
    hidden = _CLOCK.sub(lambda found: "t" * len(found.group()), text)  # of the same length, and no number
    numbers = []
    for found in _NUMBER.finditer(hidden):
        word, digits = found["word"].lower(), found.start("digits")
        if word in _VERSION and not found["between"]:
            continue
        begin = found.start("word") if word in (*_SEED, *_RUN) else digits
        numbers.append(_Number(word, begin, found.end("digits"), int(found["digits"])))
    return _Name(_CLOCK.sub("", text), tuple(_moved(numbers, text)))


def _moved(numbers: Sequence[_Number], text: str) -> list[_Number]:
    """The numbers where they stand in the text without clocks."""
    clocks = [found.span() for found in _CLOCK.finditer(text)]

    def place(position: int) -> int:
        return position - sum(end - begin for begin, end in clocks if end <= position)

    return [it._replace(begin=place(it.begin), end=place(it.end)) for it in numbers]


def _seed_in(name: _Name, alike: Sequence[_Name]) -> _Number | None:
    """Which of the numbers is the seed, if any is.

    Args:
        name: The name.
        alike: All names that differ from it in numbers alone, itself included.
    """
    for words in (_SEED, _RUN):
        told = [it for it in name.numbers if it.word in words]
        if told:
            return told[-1]
    if not name.numbers:
        return None
    differing = [
        number for place, number in enumerate(name.numbers) if len({other.numbers[place].value for other in alike}) > 1
    ]
    return (differing or list(name.numbers))[-1]


def _shared(words: Sequence[Sequence[str]]) -> int:
    """With how many equal words all begin."""
    return sum(1 for _ in takewhile(lambda at: len(set(at)) == 1, zip(*words, strict=False)))


def _shared_at_the_end(words: Sequence[Sequence[str]]) -> list[str]:
    """The equal words with which all end, the last one first; a word of each is left."""
    backwards = [list(reversed(it)) for it in words]
    return backwards[0][: min(_shared(backwards), max(0, min(map(len, words)) - 1))]


def _cut(text: str, begin: int, end: int) -> str:
    places = list(_WORDS.finditer(text))
    kept = places[begin : len(places) - end]
    return text[kept[0].start() : kept[-1].end()] if kept else ""


def _last_part(text: str) -> str:
    """The last folder or file name that says something, without separators at its ends."""
    parts = [_SEPARATORS.sub(" ", part).strip() and part.strip("-_=,. ") for part in text.split("/")]
    return next((part for part in reversed(parts) if part), "")


NEAR = 10
"""Episodes of two files that end within so many steps are compared; clocks of processes drift further than that."""
LEAST = 6
"""So many of them tell; of fewer, separate processes may have ended in one order by chance."""
FITTING = 0.9
"""The share of episodes which end in the same step that have to end at the same time; a computer may be busy once."""
CLOCK = 1e-3
"""What a clock may be wrong by, [s]."""


class _Ends(NamedTuple):
    """The ends of all episodes of several files, in the order of their steps, (rows,)."""

    steps: Float
    at: Float
    """Unix time, [s]."""
    file: Float
    last_begun: float
    """When the last file was begun, in Unix time, [s]."""
    per_step: float
    """Seconds for a step of an environment, learning included."""


def in_lockstep(logs: Iterable[Log]) -> bool | None:
    """Whether logs are of environments that one training steps together, so that it is one training.

    Such environments have taken equal numbers of steps at any time: whatever ends in an earlier step ends earlier.
    Processes of their own drift apart, and trainings one after the other are apart from the start.

    Args:
        logs: Two or more logs of episodes.

    Returns:
        True if all go together, False if some do not. None if nobody can tell: there are too few episodes, or no times.
    """
    ends = _ends_of([*logs])
    if ends is None:
        return None
    if any(ends.at[ends.file == number].max() < ends.last_begun for number in np.unique(ends.file)):
        return False
    late = _latest_disorder(ends)
    if late > CLOCK:
        return False if late > NEAR * ends.per_step else None
    gaps, waits = np.diff(ends.steps), np.diff(ends.at)
    near = (np.diff(ends.file) != 0) & (gaps <= NEAR)
    equal = waits[near & (gaps == 0)]
    is_apart = len(equal) > 0 and (equal <= NEAR * ends.per_step).mean() < FITTING
    has_no_clock = not waits[near].any()  # its ticks are too long to tell, or somebody made the times up
    return None if near.sum() < LEAST or is_apart or has_no_clock else True


def _ends_of(logs: Sequence[Log]) -> _Ends | None:
    """None where a file does not tell when its episodes ended."""
    if any(log.facts.started is None or "seconds" not in log or "time" not in log for log in logs):
        return None
    began = np.array([log.facts.started for log in logs], np.float64)
    steps = np.concatenate([log["time"] for log in logs]).astype(np.float64)
    at = np.concatenate([start + log["seconds"] for start, log in zip(began, logs, strict=True)]).astype(np.float64)
    file = np.concatenate([np.full(len(log), number, np.float64) for number, log in enumerate(logs)])
    if not np.isfinite(at).all():
        return None
    order = np.lexsort((at, steps))
    per_step = float((at.max() - began.min()) / steps.max())
    return _Ends(steps[order], at[order], file[order], float(began.max()), per_step)


def _latest_disorder(ends: _Ends) -> float:
    """By how many seconds, at most, an end came before another one's of fewer steps; 0 or less where none did."""
    latest = np.maximum.accumulate(ends.at)
    earlier = np.searchsorted(ends.steps, ends.steps, side="left")
    compared = earlier > 0
    if not compared.any():
        return 0.0
    return float((latest[earlier[compared] - 1] - ends.at[compared]).max())
