"""Finds the reward and the seed of trainings in the names of their files and folders, ``PPO_base_1``, ``prop/seed=3``.

The number that differs is the seed; what else differs is the reward. Nothing is read but names.
"""

import re
from collections.abc import Sequence
from itertools import takewhile
from typing import NamedTuple

from harness.errors import UsageError

_DAY, _HOUR = "20[0-9]{2}[-_]?[01][0-9][-_]?[0-3][0-9]", "[0-9]{2}[-_:]?[0-9]{2}[-_:]?[0-9]{2}"
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
    shortest = min(map(len, words))
    begin = min(_shared(words), max(0, shortest - 1))
    end = min(_shared([list(reversed(it)) for it in words]), max(0, shortest - begin - 1))
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


def _cut(text: str, begin: int, end: int) -> str:
    places = list(_WORDS.finditer(text))
    kept = places[begin : len(places) - end]
    return text[kept[0].start() : kept[-1].end()] if kept else ""


def _last_part(text: str) -> str:
    """The last folder or file name that says something, without separators at its ends."""
    parts = [_SEPARATORS.sub(" ", part).strip() and part.strip("-_=,. ") for part in text.split("/")]
    return next((part for part in reversed(parts) if part), "")
