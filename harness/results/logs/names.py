"""Finds the reward and the seed of trainings in the names of their files and folders, ``PPO_base_1``, ``prop/seed=3``.

The number that differs is the seed; what else differs is the reward. What names can mean in two ways is asked, with
templates that say each. Nothing is read but names, and when episodes ended: that tells the files of one training's
environments from those of several trainings.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from os.path import commonprefix
from typing import NamedTuple

import numpy as np

from harness.errors import UsageError
from harness.log import Log
from harness.text import command_text, shortened

_DAY = "20[0-9]{2}[-_/]?[01][0-9][-_/]?[0-3][0-9]|2[0-9](?:0[1-9]|1[0-2])(?:0[1-9]|[12][0-9]|3[01])"
_MONTH = "(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[0-3][0-9]"
_HOUR = "[0-2][0-9][-_:h]?[0-5][0-9](?:[-_:m]?[0-9]{2})?|/[0-2][0-9][-_:h][0-5][0-9](?:[-_:m][0-9]{2})?"
_HEX = "[0-9a-f]"
_SAYS_NOTHING = re.compile(
    rf"run-20[0-9]{{6}}_[0-9]{{6}}-[0-9a-z]{{8}}(?![0-9A-Za-z])"
    rf"|(?<![0-9])(?:1[0-9]{{9}}(?:\.[0-9]+)?|(?:{_DAY}|{_MONTH})(?:[-_T ]?(?:{_HOUR}))?)(?![0-9])"
    rf"|(?<![0-9A-Za-z])(?:{_HEX}{{8}}(?:-{_HEX}{{4}}){{3}}-{_HEX}{{12}}|{_HEX}{{5}}_0[0-9]{{4}}(?:_[0-9]+)?"
    rf"|(?={_HEX}*(?:[0-9][a-f]+[0-9]|[a-f][0-9]+[a-f])){_HEX}{{7,40}}"
    r"|(?:gpu|cuda|node|host|job|slurm)[-_:=]?[0-9]+)(?![0-9A-Za-z])"
)
"""When and where somebody trained: Unix seconds since 2001, dates with or without a time of the day, what W&B, Ray and
git call a run, numbers of machines and jobs. It is never a seed, nor a reward."""
_NUMBER = re.compile(
    r"[0-9]+(?:\.[0-9]+)+(?:e[-+]?[0-9]+)?|[0-9]+e[-+]?[0-9]+"
    r"|(?i:v|version|reward|r|k)[0-9]{1,9}(?![0-9A-Za-z]|\.[0-9])"
    r"|(?P<word>(?P<seed>(?i:seed|s|rng))|(?P<run>(?i:run|rep|repeat|replicate|trial))|[A-Za-z]*)"
    r"[-_=. ]?(?<![0-9]\.)(?<![0-9])(?P<digits>[0-9]{1,9})(?![0-9A-Za-z]|\.[0-9])"
)
"""Decimal numbers, versions of a reward, and numbers: behind a word that says seed, or one training of several."""
LONGEST_NAME = 40
"""Characters of a name that are shown."""
BETWEEN = "-_=,. /"
"""Characters between words."""
_TOKENS = re.compile(r"[-_=,. /]+|[^-_=,. /]+")


class Named(NamedTuple):
    """What a name says of a training."""

    reward: str
    """What differs from the names of other rewards; empty where nothing does."""
    seed: int | None
    """None where no number can be one."""
    place: str
    """The part of the name that says it: the same of all that belongs to one training."""


def sort_names(names: Iterable[str], template: str = "", *, is_asked: bool = True) -> dict[str, Named]:
    """The reward and the seed of each training, by the names of all of them.

    A number behind ``seed`` is the seed. Otherwise it is the one number that differs between names which differ in
    numbers alone. Versions (``v1``), decimal numbers, and what tells when and where it was trained are none.

    Args:
        names: Paths below the folder, without endings of files.
        template: How they are made, if the user says it: ``{reward}/{seed}``, ``*_{reward}_s{seed}``. ``*`` stands for
            anything within a folder's or a file's name. What it fits is one training: ``{reward}`` says that all files
            of a folder are one, ``{reward}/*`` that each file is one. Without ``{seed}`` they have none.
            ``base_{seed}|{reward}`` says it of two kinds of names: what fits the first one has the reward ``base``.
        is_asked: Whether it matters; if not, no number is the seed of names that can be read in two ways.

    Raises:
        UsageError: They can be read in two ways, or do not fit; says the flags that say each way.
    """
    if template:
        of = list(names)
        fitted = _fitted(template, of) if "{reward}" in template else {}
        for name in of:
            if name not in fitted:
                raise UsageError(
                    f"--sort '{template}' does not fit '{name}', which lies below the folder. It needs {{reward}} "
                    "once, and {seed} at most once: '{reward}/{seed}'"
                )
        return fitted
    texts = {name: _SAYS_NOTHING.sub("", name) for name in names}
    alike: dict[tuple[str, int], list[str]] = {}
    for name, text in texts.items():
        alike.setdefault((re.sub("[0-9]+", "0", text), len(_numbers_in(text))), []).append(name)
    why, seeds = "", dict[str, re.Match[str]]()
    for of in alike.values():
        columns = list(zip(*(_numbers_in(texts[name]) for name in of), strict=True))
        told = [it for it in columns if it[0]["seed"]]
        varying = [it for it in columns if len({int(number["digits"]) for number in it}) > 1]
        rivals = [it for it in varying if it not in told and (not told or it[0]["run"])]
        if len(rivals) > 1 - bool(told):
            why = "two numbers may be the seed"
        chosen = told or varying or (columns if len(of) == 1 else [])
        seeds |= zip(of, chosen[-1], strict=True) if chosen else ()
    values, rest = [int(seeds[it]["digits"]) if it in seeds else None for it in texts], texts.copy()
    for name, seed in seeds.items():  # without it, and the word that announces it
        begin = seed.start("word" if seed["seed"] or seed["run"] else "digits")
        rest[name] = texts[name][:begin] + texts[name][seed.end() :]
    found = dict(zip(texts, map(Named, labels_of([*rest.values()]), values, texts), strict=True))
    why, weighed = (why, []) if why else _doubt_of(found, texts, seeds)
    if why and is_asked:
        ways = templates_of(list(found))
        if weighed and ways:
            others = {it.reward for it in found.values()}.difference(weighed)
            ways[1:] = ["|".join([*(ways[0].replace("{reward}", it) for it in sorted(others)), "{reward}"])]
        raise question(list(found), f"can be read in two ways: {why}", ways)
    return {name: it._replace(seed=None) for name, it in found.items()} if why else found


def _doubt_of(
    found: Mapping[str, Named], texts: Mapping[str, str], seeds: Mapping[str, re.Match[str]]
) -> tuple[str, list[str]]:
    """Why the numbers that were taken for seeds may be something else, and of which rewards they may be weights."""
    named = [(texts[name], it) for name, it in seeds.items() if not (it["seed"] or it["run"])]
    depths = [(text[: it.start()].count("/"), text[it.end() :].count("/")) for text, it in named]
    if all(len({*it}) > 1 for it in zip(*depths, strict=True)) and depths:
        return "the number that differs does not stand at one place", []
    words = {it.reward: _TOKENS.findall(it.reward)[::2] for it in found.values()}
    for at in range(max(map(len, words.values()))):
        rest = {label: (*of[:at], *of[at + 1 :]) for label, of in words.items()}
        runs = {(rest[label], place if seed is None else seed) for label, seed, place in found.values()}
        if len(runs) == len(found) and 1 < len({*rest.values()}) < len(rest):
            return "what differs may be rewards, or places where one was trained", []
    numbers = {name: {it.seed for it in found.values() if it.reward == name and it.seed is not None} for name in words}
    weighed = []
    for label, own in numbers.items() if named else ():
        others = {it for name, of in numbers.items() if name != label for it in of}
        has_gaps = len(own) > 1 and max(own) - min(own) >= len(own)
        is_shared = 2 * len(own & others) >= len(own) * bool(others)
        if has_gaps and not (is_shared and any(it % 5 and it > 1 for it in own)):
            weighed.append(label)
    told = [f"{', '.join(map(str, sorted(numbers[it])[:4]))} may be seeds of '{it}', or its weights" for it in weighed]
    return "; ".join(told[:1]), weighed


def _numbers_in(text: str) -> list[re.Match[str]]:
    return [it for it in _NUMBER.finditer(text) if it["digits"]]


def labels_of(texts: Sequence[str]) -> list[str]:
    """What differs between texts, by whole words: each without the words that all begin with, or end with.

    Where nothing, or only a number, would be left of some, all keep more words at the beginning.
    """
    words = {text: _TOKENS.findall(text.strip(BETWEEN)) for text in texts}
    if len(words) == 1:
        return [next((it for part in texts[0].split("/")[::-1] if (it := part.strip(BETWEEN))), "")] * len(texts)
    begin, end = (len(commonprefix([it[::way] for it in words.values()])) for way in (1, -1))  # noqa: RUF071 (words)
    least = max(0, min(map(len, words.values())) - 1)  # a word of each is left
    end = min(end, least)
    begin = min(begin, least - end)
    while begin and any("".join(it[begin : len(it) - end]).isdecimal() for it in words.values()):
        begin -= 1
    return ["".join(words[text][begin : len(words[text]) - end]).strip(BETWEEN) for text in texts]


# Templates


def templates_of(names: Sequence[str]) -> list[str]:
    """Templates by which each name is one training, those first by which rewards have taught most.

    Args:
        names: Paths below the folder, without endings of files; each once.
    """
    texts = [_SAYS_NOTHING.sub("*", name) for name in names]
    found: dict[tuple[int, ...], tuple[bool, bool, int, str]] = {}
    for parts in (_TOKENS, re.compile("/|[^/]+")):
        rows = [parts.findall(text) for text in texts]
        if len({*map(len, rows)}) > 1:
            continue
        columns = [[*dict.fromkeys(it)] for it in zip(*rows, strict=True)]
        varying = [at for at, of in enumerate(columns) if len(of) > 1] or [len(columns) - 1]
        told = [at for at in varying if "*" not in columns[at][0]]
        for reward, seed in product(told, [None, *told]):
            shown = [of[0] if len(of) == 1 else "*" for of in columns]
            if seed is not None:
                shown[seed] = re.sub("[0-9]{1,9}$", "{seed}", columns[seed][0])
            ending = re.search(r"([-_=. ]|(?<=[A-Za-z]))\{seed\}$", shown[reward])
            shown[reward] = "{reward}" + (ending[0] if ending else "")
            template = re.sub(r"\*+", "*", "".join(shown))
            fitted = _fitted(template, names).values()
            rewards = [it.reward for it in fitted]
            runs = {(it.reward, it.place if it.seed is None else it.seed) for it in fitted}
            of_seeds = any(it["seed"] for name in rewards for it in _numbers_in(name))
            if len(runs) == len(names) and not of_seeds:
                rank = min(map(rewards.count, rewards)) < 2, "{seed}" not in template, template.count("*"), template
                key = tuple(map(rewards.index, rewards))
                found[key] = min(rank, found.get(key, rank))
    return [template for *_, template in sorted(found.values())]


def question(names: Sequence[str], why: str, ways: Sequence[str] | None = None) -> UsageError:
    """What to say where names do not tell which trainings there are, with the templates that can be meant.

    Args:
        names: Paths below the folder, without endings of files.
        why: What is doubtful.
        ways: The templates, if it is known which.
    """
    shown = []
    for way in (templates_of(names) if ways is None else ways)[:2]:
        found = _fitted(way, names)
        if found.keys() == {*names}:
            count, rewards = len({it.place for it in found.values()}), len({it.reward for it in found.values()})
            shown.append(f"{command_text('--sort', way)} ({count} trainings of {rewards} reward{'s' * (rewards != 1)})")
    remedy = f"Say {', or '.join(shown)}" if shown else "Call the folder of each REWARD/SEED"
    seen = " and ".join(f"'{shortened(name, LONGEST_NAME)}'" for name in dict.fromkeys([names[0], names[-1]]))
    return UsageError(f"Names such as {seen} {why}. {remedy}")


def _fitted(template: str, names: Iterable[str]) -> dict[str, Named]:
    """What a template says of the names that fit it."""
    found = dict[str, Named]()
    for way in template.split("|"):
        pattern = re.escape(way).replace(r"\{seed\}", "(?P<seed>[0-9]{1,9})", 1).replace(r"\*", "[^/]*?")
        pattern = pattern.replace(r"\{reward\}", "(?P<reward>[^/]+?)", 1)
        pattern = f"(?P<place>(?:.*?/)??{pattern})(?:[.][^/]*)?(?:/.*)?"
        for name in names:
            if match := re.fullmatch(pattern, name):
                told = match.groupdict()
                reward = told.get("reward") or re.sub(r"[-_=,. /]*(\{seed\}|\*)[-_=,. /]*", "", way)
                seed = int(told["seed"]) if "seed" in told else None
                found.setdefault(name, Named(reward, seed, told["place"]))
    return found


# Times


NEAR = 10
"""Episodes of two files that end within so many steps are compared; clocks of processes drift further than that."""
LEAST = 6
"""So many of them tell; of fewer, separate processes may have ended in one order by chance."""
APART = 0.1
"""The share of episodes which end in the same step that may end at other times; a computer may be busy once."""
CLOCK = 1e-3
"""What a clock may be wrong by, [s]."""


def in_lockstep(logs: Sequence[Log]) -> bool | None:
    """Whether logs are of environments that one training steps together, so that it is one training.

    Such environments have taken equal numbers of steps at any time: whatever ends in an earlier step ends earlier.
    Processes of their own drift apart, and trainings one after the other are apart from the start.

    Args:
        logs: Two or more logs of episodes.

    Returns:
        True if all go together, False if some do not. None if nobody can tell: there are too few episodes, or no times.
    """
    if any(log.facts.started is None or "seconds" not in log or "time" not in log for log in logs):
        return None
    began = [log.facts.started or 0.0 for log in logs]
    ends = [start + log["seconds"].astype(np.float64) for start, log in zip(began, logs, strict=True)]
    at, steps = np.concatenate(ends), np.concatenate([log["time"] for log in logs]).astype(np.float64)
    if not np.isfinite(at).all():
        return None
    if any(of.max() < max(began) for of in ends):
        return False
    order = np.lexsort((at, steps))
    file = np.repeat(np.arange(len(logs)), [*map(len, logs)])[order]
    steps, at = steps[order], at[order]
    per_step = (at.max() - min(began)) / steps.max()  # seconds for a step of an environment, learning included
    late = (np.maximum.accumulate(at)[:-1] - at[1:]).max(initial=0.0)  # how long before one of fewer steps an end came
    if late > CLOCK:
        return False if late > NEAR * per_step else None
    gaps, waits = np.diff(steps), np.diff(at)
    near = (np.diff(file) != 0) & (gaps <= NEAR)
    equal = waits[near & (gaps == 0)]
    is_apart = (equal > NEAR * per_step).sum() > APART * len(equal)
    has_no_clock = not waits[near].any()  # its ticks are too long to tell, or somebody made the times up
    return None if near.sum() < LEAST or is_apart or has_no_clock else True
