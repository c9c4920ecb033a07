"""What the columns of a log are for: one dictionary of names, of tables and charts and TensorBoard's tags alike."""

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from harness import Float
from harness.errors import SchemaError, UsageError, one_line
from harness.eta.laws import NEARLY_ALL as NEARLY_ALL  # noqa: PLC0414 (for the reader of event files)
from harness.log import Log, LogFacts, in_memory, require_columns
from harness.score.row_meaning import EPISODE, LENGTH

if TYPE_CHECKING:
    from harness.log.facts import Unit

LAST_100 = "a mean over the last 100 episodes"
ONE = "that of an episode"
NEW = "a mean over the episodes that ended since the point before"
LAST_100_OR_NEW = "a mean over the episodes of an iteration, or over the last 100"
EVALUATED = "a mean over the episodes of an evaluation"
TIME, ITERATION = "time", "iteration"
MOST_RESTARTS = 100
SOON = 0.05
"""The share of a training before which one that begins again is another one: no checkpoint is so early."""
CLEANRL_RUN = re.compile(r"(?P<env>.+?)__(?P<algorithm>[^_]+).*__(?P<seed>\d+)__\d+")
"""What CleanRL calls a run, and its folder."""
WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
AROUND = {"train", "training", "rollout", "charts", "100"}
EVALUATIONS = {"eval", "evaluation", "evaluations", "test", "testing", "validation"}
"""Words around a name that say of which episodes it tells."""
LONG = 9
"""A name of so many letters says what it is wherever it stands, as in ``a/b/ep_rew_mean``; a short one only alone."""


def plain(name: str) -> str:
    """A name without its signs, its capitals, and the words that say of which episodes it tells."""
    words = (word.lower() for word in WORDS.findall(name))
    return "".join(word for word in words if word not in AROUND | EVALUATIONS)


_NAMES = {
    "reward": """
        eprewmean episodereturnmean episoderewardmean meanreward meanreturn averageepret rewardsstep totalrewardmean
        averagereturn averagereward avgreturn avgreward meanepisodereturn meanepisodereward returnsstatmean
        episodicreturn return returns episodereturn epreturn epret returnmean rewardmean reward rewards episodereward
        epreward eprew episodicreward totalreward totalreturn sumreward cumulativereward episodescore score r
    """,
    "success": """
        successrate successratemean successmean success issuccess episodesuccess successonce succeeded successful
        reached goalreached solved
    """,
    "length": f"""
        eplenmean episodelenmean meaneplength episodiclength meanepisodelength episodelengthsstep totaltimestepsmean
        lensstatmean {" ".join(map(plain, LENGTH))}
    """,
    "time": """
        totaltimesteps globalstep numenvstepssampledlifetime timestepstotal numenvstepssampled totalenvinteracts
        totalenvsteps timestepssofar totalsteps envsteps envstep environmentsteps cumulativesteps numtimesteps
        totalframes collectedframes numframes timesteps steps
    """,
    "episode": " ".join(map(plain, EPISODE)),
    "counter": "iteration iterations timeiterations epoch epochs update updates timestep step episode",
    # Of text: what taught a training, and which of its rows count; the last three of the first may be of all files
    "taught": """
        rewardfn rewardfunction rewardname rewardtype reward method variant condition treatment algo algorithm group
    """,
    "mode": "mode split phase stage agent agentid player policyid",
}
ROLES: Mapping[str, Sequence[str]] = {role: names.split() for role, names in _NAMES.items()}
"""What a column is for, by its `plain` name; the first of these that is there."""
POINTS: Mapping[str, tuple[str, bool]] = {
    "Training/Episode Return": (LAST_100, True),
    "rollout/success_rate": (LAST_100, True),
    "eval/mean_reward": (EVALUATED, True),
    "eprewmean": (LAST_100, True),
    "rewardsstep": (LAST_100, True),
    "meanreward": (LAST_100, False),
    "totalrewardmean": (NEW, False),
    "episodereturnmean": (LAST_100_OR_NEW, False),
    "episoderewardmean": (LAST_100_OR_NEW, False),
    "averageepret": (NEW, False),
    "returnsstatmean": (NEW, True),
    "cumulativereward": (NEW, True),
    "episodicreturn": (ONE, True),
    "episodescore": (ONE, True),
}
"""By the name of a return, or its `plain` name: what a point is, and whether TensorBoard's step counts env steps."""
Series: TypeAlias = Sequence[Float]
"""The points of one tag: their steps, and their values."""
VALUES = ("reward", "success", "length", "measure")
OF_ALL = ("steps", "timesteps", "numsteps", "nsteps")
"""Names of lengths in tables of episodes, and of the steps of a training beside a curve."""
MEANS = re.compile("mean|average|avg|rate$")


class Chosen(NamedTuple):
    """Which names of a log are read."""

    columns: Mapping[str, str]
    """By role: ``reward``, ``success``, ``length``, ``measure``."""
    times: tuple[str, ...] = ()
    """Those that count environment steps over all envs; the first that is filled is read."""
    counter: str = ""
    """What counts anything else; empty where nothing does."""
    episode: str = ""
    """What counts episodes."""
    unit: "Unit" = "point"
    """What a row of a table is."""
    evaluation: bool = False
    """Whether the episodes are of evaluations."""
    others: tuple[str, ...] = ()
    """Returns that are there and are not read."""

    @property
    def main(self) -> str:
        """The name whose values are its points."""
        return self.columns.get("reward") or self.columns["success"]

    @property
    def is_mean(self) -> bool:
        """Whether its names say that a value stands for several episodes."""
        return any(MEANS.search(plain(name.rpartition("/")[2])) for name in self.columns.values())

    @property
    def kind(self) -> tuple[str, bool]:
        """What a point is, empty where nobody knows; and whether TensorBoard's step counts environment steps."""
        keys = (self.main, plain(self.main), plain(self.main.rpartition("/")[2]))
        point, is_of_steps = next((POINTS[key] for key in keys if key in POINTS), ("", False))
        return EVALUATED if self.evaluation else point, is_of_steps


@dataclass(frozen=True)
class Roles:
    """What a user can say of a log of curves.

    Attributes:
        time: The column, or tag, that counts environment steps; as the others, found by its name if empty.
        reward: That of returns.
        success: That of success, or of the share of episodes that succeeded.
        length: That of lengths.
        measure: That of one more measure, which no reward enters.
        per_step: Environment steps of one of its steps, where these are iterations; 0 if nobody says.
        episode: Steps of an episode at most, where values average many and no lengths stand beside them; 0 if nobody
            says.
    """

    time: str = ""
    reward: str = ""
    success: str = ""
    length: str = ""
    measure: str = ""
    per_step: int = 0
    episode: int = 0

    def chosen(self, path: Path, names: Sequence[str]) -> Chosen:
        """What to read among the names of a log.

        Raises:
            UsageError: A name that was given is not there, or none is known.
        """
        given = {role: getattr(self, role) for role in VALUES}
        require_columns(path, names, self.time, *given.values())
        of: dict[bool, dict[str, str]] = {False: {}, True: {}}
        for evaluated, role in product(of, (*VALUES[:3], "episode")):
            best = _named((name for name in names if is_evaluated(name) == evaluated), role)
            if best:
                of[evaluated][role] = best[0]
        there = [it for it, roles in of.items() if {"reward", "success"} & roles.keys()]
        evaluation = min(there, key=lambda it: ("success" not in of[it], it), default=False)
        if self.reward or self.success:
            evaluation = is_evaluated(self.reward or self.success)
        roles = {role: name for role, name in of[evaluation].items() if name != self.time}
        roles |= {role: name for role, name in given.items() if name}
        if not {"reward", "success"} & roles.keys():
            raise UsageError(
                f"{path} has no curve of returns that is known by its name: say reward=NAME. "
                f"It has: {one_line(', '.join(names), 160)}"
            )
        columns = {role: roles[role] for role in VALUES if role in roles}
        chosen = Chosen(columns, episode=roles.get("episode", ""), evaluation=evaluation)
        is_known = chosen.kind[0] and not chosen.episode
        has_points = chosen.is_mean or is_known or is_history(names) or not {"episode", "length"} & roles.keys()
        if has_points and not self.length and plain(columns.get("length", "")) in OF_ALL:
            del columns["length"]
        nearest = sorted(names, key=lambda name: is_evaluated(name) != evaluation)
        free = [name for name in nearest if name not in columns.values()]
        counters = (name for name in _named(free, "counter") if name != chosen.episode or has_points)
        return chosen._replace(
            unit="point" if has_points else "episode",
            times=(self.time,) if self.time else tuple(_named(free, "time")),
            counter=next(counters, ""),
            others=tuple(name for it in of.values() if (name := it.get("reward")) not in (None, columns.get("reward"))),
        )


def is_history(names: Collection[str]) -> bool:
    """Whether these are of the history of a run of Weights & Biases, which has the names of whatever logged into it."""
    return {"_step", "_timestamp"} <= {*names}


def cleanrl_run(name: str) -> dict[str, Any]:
    """What CleanRL tells of a training by what it calls the run: its environment, its algorithm, its seed."""
    named = CLEANRL_RUN.fullmatch(name)
    return {**named.groupdict(), "seed": int(named["seed"])} if named else {}


def is_evaluated(name: str) -> bool:
    """Whether a name says that it tells of evaluations."""
    return any(word.lower() in EVALUATIONS for word in WORDS.findall(name))


def _named(names: Iterable[str], role: str) -> list[str]:
    """The names of a role, those first that say it best."""
    names = list(names)
    found = {plain(name): name for name in reversed(names)}
    for name in names:
        key = plain(name.rpartition("/")[2])
        if len(key) >= LONG:
            found.setdefault(key, name)
    return list(dict.fromkeys(found[key] for key in ROLES[role] if key in found))


def points(facts: LogFacts, chosen: Chosen, columns: Mapping[str, Float], told: Roles, step: str = "") -> Log:
    """The log of one curve.

    Args:
        facts: Of the file.
        chosen: Which of its names to read.
        columns: By name, (points,) each, and ``step``, what its own steps count; NaN where a point lacks a value.
        told: What a user said.
        step: What ``step`` counts. Where it is empty, as of TensorBoard, or called so, the names of the values tell
            whether it counts environment steps.

    Raises:
        UsageError: The log tells environment steps itself, and a user says how many one of its steps is.
        SchemaError: No point has all of its values, one is beyond what it can be, or its steps go back too often.
    """
    point, is_of_steps = chosen.kind
    is_point = ~np.isnan(columns[chosen.main])
    filled = (name for name in chosen.times if name in columns and not np.isnan(columns[name][is_point]).all())
    counter = next(filled, "step")
    told_by = step if counter == "step" else counter
    tells_time = counter != "step" or plain(step) in ROLES["time"]
    if told.per_step and tells_time:
        raise UsageError(f"{facts.path} counts environment steps in '{told_by}': leave per_step out")
    is_time = tells_time or (is_of_steps and step in ("", "step")) or told.per_step > 0
    axis = TIME if is_time else ITERATION
    read = {column_of(role, name): name for role, name in chosen.columns.items() if role != "length"}
    is_whole = ~np.isnan([columns[name] for name in (counter, *read.values())]).any(axis=0)
    lacking, steps = int((is_point & ~is_whole).sum()), columns[counter][is_whole]
    back = np.flatnonzero(np.diff(steps) < 0.0) + 1
    if len(back) > MOST_RESTARTS:
        raise SchemaError(
            f"{facts.path}: its steps go back {len(back):,} times: several trainings write to it, or none"
        )
    counts = np.ones(len(steps), bool)
    for row in back:  # what was logged before a restart, and was logged again later
        last = steps[:row].max()
        if steps[row] - steps[0] <= SOON * last and last >= NEARLY_ALL * steps[row:].max():
            raise SchemaError(
                f"{facts.path}: its steps go from {last:,.0f} to {steps[row]:,.0f}: it holds several trainings, or "
                "one whose steps were counted from 0 again. Give each a file"
            )
        counts[:row] &= steps[:row] < steps[row]
    rows = np.flatnonzero(is_whole)[counts]
    if not len(rows):
        raise SchemaError(f"{facts.path} has no point of {', '.join(chosen.columns.values())} yet")
    length = chosen.columns.get("length", "")
    lengths = columns[length][rows] if length else np.full(len(rows), np.nan)
    is_told = ~np.isnan(lengths)
    if length and is_told.all():
        read["length"] = length
    after = columns[counter][rows]
    if told.per_step:
        is_from_0 = np.nanmin(columns[counter]) == 0.0  # then the first one was over when it was logged
        after = (after + is_from_0) * told.per_step
    found = {axis: after, **{column: columns[name][rows] for column, name in read.items()}}
    if is_time and is_told.any():
        lengths = np.interp(after, after[is_told], lengths[is_told])
    else:
        lengths = np.full(len(rows), told.episode or np.nan if is_time else np.nan)
    before = np.concatenate([[0.0], after[:-1]])
    last_100 = np.maximum(after - 100.0 * lengths, 0.0)
    since = {
        EVALUATED: after,
        NEW: before,
        ONE: np.where(np.isnan(lengths), before, np.maximum(after - lengths, 0.0)),
        LAST_100_OR_NEW: np.minimum(before, last_100),
    }
    found["since"] = since.get(point, last_100)
    shown = ", ".join(f"{column} from '{name}'" for column, name in read.items())
    notes = {
        f"{shown}; {axis} from " + (f"'{told_by}'" if told_by else "its steps"): True,
        "nobody says how many environment steps one of its steps is: per_step=N does": not is_time,
        f"'{length}' lacks values: it is left out": length and "length" not in read,
        f"{lacking} points that lack one of these are left out": lacking,
        f"{len(back)} times it goes back: what was logged again later counts": len(back),
        f"there are also curves of {', '.join(chosen.others)}": chosen.others,
    }
    thinned = [facts.thinned, f"each value is {point}" if point not in ("", ONE) else ""]
    facts = replace(
        facts,
        unit="point",
        evaluation=chosen.evaluation,
        bounds={"success": (0.0, 1.0)} if "success" in chosen.columns else {},
        thinned="; ".join(filter(None, thinned)),
        notes=(*facts.notes, *(note for note, is_so in notes.items() if is_so)),
    )
    return in_memory(facts, found)


def column_of(role: str, name: str) -> str:
    """The standard column of a role."""
    return {"reward": "reward/recorded", "success": "behaviour/success"}.get(role, f"behaviour/{name}")


def curve(facts: LogFacts, series: Mapping[str, Series], told: Roles, step: str = "") -> Log:
    """The log of one curve, of tags with points of their own: with a point for each of the tag that is read first.

    Args:
        facts: Of the file.
        series: By tag.
        told: What a user said.
        step: What their steps count, see `points`.
    """
    chosen = told.chosen(facts.path, list(series))
    steps, _ = series[chosen.main]
    columns = {"step": steps}
    for tag in (*chosen.columns.values(), *chosen.times):
        values = dict(zip(_numbered(series[tag][0]), series[tag][1].tolist(), strict=True))
        columns[tag] = np.array([values.get(it, np.nan) for it in _numbered(steps)])
    return points(facts, chosen, columns, told, step)


def _numbered(steps: Float) -> Iterator[tuple[float, int]]:
    """Each step, and how often it stood there before: several episodes may end at one step."""
    seen: Counter[float] = Counter()
    for step in steps.tolist():
        yield step, seen[step]
        seen[step] += 1
