"""Finds the reward and the seed of trainings in the names of their files and folders, ``PPO_base_1``, ``prop/seed=3``.

The number that differs is the seed; what else differs is the reward. What names can mean in two ways is asked, with
templates that say each. Nothing is read but names, and when episodes ended: that tells the files of one training's
environments from those of several trainings.
"""

import re
from collections.abc import Collection, Iterable, Sequence
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from harness.errors import UsageError
from harness.log import Log
from harness.text import command_text

_DAY = "20[0-9]{2}[-_]?[01][0-9][-_]?[0-3][0-9]|2[0-9](?:0[1-9]|1[0-2])(?:0[1-9]|[12][0-9]|3[01])"
_MONTH = "(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[0-3][0-9]"
_HOUR = "[0-2][0-9][-_:h]?[0-5][0-9](?:[-_:m]?[0-9]{2})?"
_HEX = "[0-9a-f]"
_SAYS_NOTHING = re.compile(
    rf"(?<![0-9])(?:1[0-9]{{9}}(?:\.[0-9]+)?|(?:{_DAY}|{_MONTH})(?:[-_T /]?{_HOUR})?(?:-[0-9a-z]{{8}})?)(?![0-9])"
    rf"|(?<![0-9A-Za-z])(?:{_HEX}{{8}}(?:-{_HEX}{{4}}){{3}}-{_HEX}{{12}}|{_HEX}{{5}}_[0-9]{{5}}(?:_[0-9]+)?"
    rf"|(?={_HEX}*(?:[0-9][a-f]+[0-9]|[a-f][0-9]+[a-f])){_HEX}{{7,40}}"
    r"|(?:gpu|cuda|node|host|job|slurm)[-_:=]?[0-9]+)(?![0-9A-Za-z])"
)
"""When and where somebody trained: Unix seconds since 2001, dates with or without a time of the day, what W&B, Ray and
git call a run, numbers of machines and jobs. It is never a seed, nor a reward."""
_NUMBER = re.compile(
    r"[0-9]+(?:\.[0-9]+)+(?:e[-+]?[0-9]+)?|[0-9]+e[-+]?[0-9]+"
    r"|(?P<word>[A-Za-z]*)(?P<between>[-_=. ]?)(?<![0-9]\.)(?<![0-9])(?P<digits>[0-9]{1,9})(?![0-9A-Za-z]|\.[0-9])"
)
_SEED = ("seed", "s", "rng")
_RUN = ("run", "rep", "repeat", "replicate", "trial")
_VERSION = ("v", "version", "reward", "r", "k")
"""Words before a number: it is the seed; it is one training of several; it names a variant of a reward."""
_SEPARATORS = re.compile(r"[-_=,. /]+")
_WORDS = re.compile(r"[^-_=,. /]+")
_MARKS = re.compile(r"(\{seed\}|\*)")


class Named(NamedTuple):
    """What a name says of a training."""

    reward: str
    """What differs from the names of other rewards; empty where nothing does."""
    seed: int | None
    """None where no number can be one."""
    place: str
    """The part of the name that says it: the same of all that belongs to one training."""


def sort_names(names: Sequence[str], *, is_asked: bool = True) -> list[Named]:
    """The reward and the seed of each training, by the names of all of them.

    A number behind ``seed`` is the seed. Otherwise it is the one number that differs between names which differ in
    numbers alone. Versions (``v1``), decimal numbers, and what tells when and where it was trained are none.

    Args:
        names: Paths below the folder, without endings of files; each once.
        is_asked: Whether it matters; if not, no number is the seed of names that can be read in two ways.

    Raises:
        UsageError: They can be read in two ways; says which, and the flags that say each.
    """
    texts = [_SAYS_NOTHING.sub("", name) for name in names]
    numbers = [_numbers_in(text) for text in texts]
    alike: dict[str, list[int]] = {}
    for place, text in enumerate(texts):
        alike.setdefault(re.sub("[0-9]+", "0", text) if numbers[place] else text, []).append(place)
    seeds: list[re.Match[str] | None] = [None] * len(names)
    doubt, weighed = "", list[str]()
    for of in alike.values():
        columns = list(zip(*(numbers[place] for place in of), strict=True))
        told = [it for it in columns if _word_of(it[0]) in _SEED]
        varying = [it for it in columns if len({int(number["digits"]) for number in it}) > 1]
        rivals = [it for it in varying if it not in told and (not told or _word_of(it[0]) in _RUN)]
        if len(rivals) > 1 - bool(told):
            doubt = "two numbers differ, and none of them is called the seed, or both are"
        chosen = told or varying or (columns if len(of) == 1 else [])
        for place, number in zip(of, chosen[-1] if chosen else (), strict=False):
            seeds[place] = number
    rest = [_cut(text, it) for text, it in zip(texts, seeds, strict=True)]
    values = [None if it is None else int(it["digits"]) for it in seeds]
    found = [Named(*it) for it in zip(labels_of(rest), values, names, strict=True)]
    if not doubt:
        doubt, weighed = _doubt_of(found, texts, seeds)
    if doubt and is_asked:
        raise question(names, f"can be read in several ways: {doubt}", weighed)
    return [it._replace(seed=None) for it in found] if doubt else found


def _numbers_in(text: str) -> list[re.Match[str]]:
    found = (it for it in _NUMBER.finditer(text) if it["digits"])
    return [it for it in found if it["between"] or it["word"].lower() not in _VERSION]


def _word_of(number: re.Match[str]) -> str:
    return number["word"].lower()


def _cut(text: str, seed: re.Match[str] | None, mark: str = "") -> str:
    """The text without a seed and the word that announces it."""
    if seed is None:
        return text
    begin = seed.start("word") if not mark and _word_of(seed) in (*_SEED, *_RUN) else seed.start("digits")
    return text[:begin] + mark + text[seed.end() :]


def _doubt_of(
    found: Sequence[Named], texts: Sequence[str], seeds: Sequence[re.Match[str] | None]
) -> tuple[str, list[str]]:
    """Why the numbers that were taken for seeds may be something else, and of which rewards they may be weights."""
    named = [(text, it) for text, it in zip(texts, seeds, strict=True) if it and _word_of(it) not in (*_SEED, *_RUN)]
    before = {len(_SEPARATORS.findall(text[: it.start("digits")])) for text, it in named}
    behind = {len(_SEPARATORS.findall(text[it.end() :])) for text, it in named}
    if len(before) > 1 and len(behind) > 1:
        return "the number that differs does not stand at one place", []
    words = {label: tuple(_WORDS.findall(label)) for label, _, _ in found}
    for at in range(max(map(len, words.values()))):
        rest = {label: of[:at] + of[at + 1 :] for label, of in words.items()}
        runs = {(rest[label], place if seed is None else seed) for label, seed, place in found}
        if len(runs) == len(found) and 1 < len({*rest.values()}) < len(rest):
            return "what differs may be two rewards, or two places where one was trained", []
    of_rewards: dict[str, set[int]] = {}
    for label, seed, _ in found:
        of_rewards.setdefault(label, set()).update([] if seed is None else [seed])
    weighed = []
    for label, own in of_rewards.items() if named else ():
        others = set[int]().union(*(it for name, it in of_rewards.items() if name != label))
        is_shared = not others or 2 * len(own & others) >= len(own)
        is_counted = len(own) < 2 or max(own) - min(own) < len(own)
        if not is_counted and (not is_shared or all(it % 5 == 0 or it == 1 for it in own)):
            weighed.append(label)
    shown = ", ".join(map(str, sorted(of_rewards[weighed[0]]))) if weighed else ""
    return f"{shown} may be seeds of '{weighed[0]}', or its weights" if weighed else "", weighed


def labels_of(texts: Sequence[str]) -> list[str]:
    """What differs between texts, by whole words: each without the words that all begin with, or end with.

    Where nothing, or only a number, would be left of some, all keep more words at the beginning.
    """
    words = {text: list(_WORDS.finditer(text)) for text in texts}
    said = [[it.group() for it in of] for of in words.values()]
    if len(said) == 1:
        parts = [_SEPARATORS.sub(" ", part).strip() and part.strip("-_=,. ") for part in texts[0].split("/")]
        return [next(filter(None, reversed(parts)), "")] * len(texts)
    most = max(0, min(map(len, said)) - 1)
    end = min(most, _shared([it[::-1] for it in said]))
    begin = min(most - end, _shared(said))
    while begin and any("".join(it[begin : len(it) - end]).isdecimal() for it in said):
        begin -= 1
    kept = {text: of[begin : len(of) - end] for text, of in words.items()}
    return [text[kept[text][0].start() : kept[text][-1].end()] if kept[text] else "" for text in texts]


def _shared(words: Sequence[Sequence[str]]) -> int:
    """With how many equal words all begin."""
    return sum(1 for _ in takewhile(lambda at: len({*at}) == 1, zip(*words, strict=False)))


# Templates


def templates_of(names: Sequence[str]) -> list[str]:
    """Templates by which each name is one training, those first by which rewards have taught most.

    Args:
        names: Paths below the folder, without endings of files; each once.
    """
    texts = [_SAYS_NOTHING.sub("*", name) for name in names]
    numbers = [_numbers_in(text) for text in texts]
    slots = range(max(map(len, numbers)))
    marked = [texts, *([_marked(*it, -1 - at) for it in zip(texts, numbers, strict=True)] for at in slots)]
    marked += [[_marked(*it, at) for it in zip(texts, numbers, strict=True)] for at in slots]
    found: dict[frozenset[tuple[str, str]], tuple[bool, bool, str]] = {}
    for template in dict.fromkeys(template for of in marked for template in _templates(of)):
        try:
            sorted_ = sort_by_template(template, names)
        except UsageError:
            continue
        runs = {(reward, place if seed is None else seed) for reward, seed, place in sorted_}
        rewards = {it.reward for it in sorted_}
        counts = [sum(it.reward == name for it in sorted_) for name in rewards]
        if len(runs) == len(names):
            key = frozenset((it.reward, name) for it, name in zip(sorted_, names, strict=True))
            rank = min(counts) < 2, "{seed}" not in template, template
            found[key] = min(rank, found.get(key, rank))
    good = [rank for rank in found.values() if not rank[0]]
    return [template for *_, template in sorted(good if len(good) > 1 else found.values())]


def _marked(text: str, numbers: Sequence[re.Match[str]], at: int) -> str:
    return _cut(text, numbers[at], "{seed}") if -len(numbers) <= at < len(numbers) else text


def _templates(marked: Sequence[str]) -> list[str]:
    """Templates that fit names in which the seeds, and what says nothing, are marked."""
    different = [re.findall(r"[-_=,. /]+|[^-_=,. /]+", text) for text in dict.fromkeys(marked)]
    begin, end = _shared(different), _shared([it[::-1] for it in different])
    if len(different) == 1:
        begin, end = len(different[0]) - 1, 0
    end = min(end, *(len(it) - begin for it in different))
    head, tail = "".join(different[0][:begin]), "".join(different[0][len(different[0]) - end :])
    found = []
    for border in (r"(/|\{seed\}|\*)", r"([-_=,. /]+|\{seed\}|\*)"):
        parts = [re.split(border, "".join(it[begin : len(it) - end])) for it in different]
        if len({len(it) for it in parts}) > 1 or len({tuple(it[1::2]) for it in parts}) > 1:
            continue
        columns = [{*it} for it in zip(*parts, strict=True)]
        for at in range(0, len(columns), 2):
            if columns[at] != {""}:
                shown = [next(iter(it)) if len(it) == 1 else "*" for it in columns]
                found.append(re.sub(r"\*+", "*", head + "".join([*shown[:at], "{reward}", *shown[at + 1 :]]) + tail))
    return found


def question(names: Sequence[str], why: str, weighed: Collection[str] = ()) -> UsageError:
    """What to say where names do not tell which trainings there are, with the templates that can be meant.

    Args:
        names: Paths below the folder, without endings of files; each once.
        why: What is doubtful.
        weighed: Rewards of which each number may be another one.
    """
    ways = templates_of(names)[:3]
    if weighed:
        others = dict.fromkeys(it.reward for it in sort_by_template(ways[0], names) if it.reward not in weighed)
        ways[1:] = ["|".join([*(ways[0].replace("{reward}", it) for it in others), "{reward}"])]
    shown = []
    for way in ways:
        first, *more = dict.fromkeys(it.reward for it in sort_by_template(way, names))
        shown.append(f"{command_text('--sort', way)} ({len(more) + 1} rewards, such as `{[first, *more][-1]}`)")
    remedy = f"Say {', or '.join(shown)}" if ways else "Name them REWARD/SEED, and say --sort '{reward}/{seed}'"
    return UsageError(f"Names such as '{names[0]}' and '{names[-1]}' {why}. {remedy}")


def sort_by_template(template: str, names: Sequence[str]) -> list[Named]:
    """The same where the user says how names are made: ``{reward}/{seed}``, ``*_{reward}_s{seed}``.

    ``*`` stands for anything within a folder's or a file's name. What the template fits is one training: ``{reward}``
    says that all files of a folder are one, ``{reward}/*`` that each file is one. Without ``{seed}`` they have none.
    ``base_{seed}|{reward}`` says it of two kinds of names: what fits the first one has the reward ``base``.

    Raises:
        UsageError: It has no ``{reward}``, or a name is not made so.
    """
    ways = template.split("|")
    if "{reward}" not in template or any(it.count("{reward}") > 1 or it.count("{seed}") > 1 for it in ways):
        raise UsageError(f"--sort '{template}' needs {{reward}} once, and {{seed}} at most once: '{{reward}}/{{seed}}'")
    patterns = {}
    for way in ways:
        pattern = re.escape(way).replace(r"\{seed\}", "(?P<seed>[0-9]{1,9})").replace(r"\*", "[^/]*?")
        pattern = pattern.replace(r"\{reward\}", "(?P<reward>[^/]+?)")
        patterns[way] = re.compile(f"(?P<place>(?:.*?/)??{pattern})(?:[.][^/]*)?(?:/.*)?")
    found = []
    for name in names:
        fits = ((way, match.groupdict()) for way, it in patterns.items() if (match := it.fullmatch(name)))
        way, told = next(fits, ("", {}))
        if not told:
            raise UsageError(f"--sort '{template}' does not fit '{name}', which lies below the folder")
        reward = told.get("reward") or "".join(_MARKS.split(way)[::2]).strip("-_=,. /")
        found.append(Named(reward, int(told["seed"]) if "seed" in told else None, told["place"]))
    return found


# Times


NEAR = 10
"""Episodes of two files that end within so many steps are compared; clocks of processes drift further than that."""
LEAST = 6
"""So many of them tell; of fewer, separate processes may have ended in one order by chance."""
FITTING = 0.9
"""The share of episodes which end in the same step that have to end at the same time; a computer may be busy once."""
CLOCK = 1e-3
"""What a clock may be wrong by, [s]."""


def in_lockstep(logs: Iterable[Log]) -> bool | None:
    """Whether logs are of environments that one training steps together, so that it is one training.

    Such environments have taken equal numbers of steps at any time: whatever ends in an earlier step ends earlier.
    Processes of their own drift apart, and trainings one after the other are apart from the start.

    Args:
        logs: Two or more logs of episodes.

    Returns:
        True if all go together, False if some do not. None if nobody can tell: there are too few episodes, or no times.
    """
    of = [(log.facts.started, log) for log in logs]
    began = [started for started, log in of if started is not None and "seconds" in log and "time" in log]
    if len(began) < len(of):
        return None
    steps = np.concatenate([log["time"] for _, log in of]).astype(np.float64)
    at = np.concatenate([start + log["seconds"] for start, (_, log) in zip(began, of, strict=True)]).astype(np.float64)
    if not np.isfinite(at).all():
        return None
    order = np.lexsort((at, steps))
    steps, at, file = steps[order], at[order], np.repeat(np.arange(len(of)), [len(log) for _, log in of])[order]
    if any(at[file == number].max() < max(began) for number in np.unique(file)):
        return False
    per_step = (at.max() - min(began)) / steps.max()  # seconds for a step of an environment, learning included
    earlier = np.searchsorted(steps, steps, side="left")
    waited = np.maximum.accumulate(at)[earlier - 1] - at  # by how much an end came before one of fewer steps
    late = waited[earlier > 0].max(initial=0.0)
    if late > CLOCK:
        return False if late > NEAR * per_step else None
    gaps, waits = np.diff(steps), np.diff(at)
    near = (np.diff(file) != 0) & (gaps <= NEAR)
    equal = waits[near & (gaps == 0)]
    is_apart = len(equal) > 0 and (equal <= NEAR * per_step).mean() < FITTING
    has_no_clock = not waits[near].any()  # its ticks are too long to tell, or somebody made the times up
    return None if near.sum() < LEAST or is_apart or has_no_clock else True
