"""Learning curves as programs of others log them: by what names, what a point is, and what its step counts."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Ints
from harness.errors import SchemaError, UsageError
from harness.log import Log, LogFacts, in_memory
from harness.log.log import BEHAVIOUR, LARGEST, RECORDED, REWARD, SINCE, SUCCESS
from harness.log.text_table import require_columns
from harness.progress import RETURN, SUCCESS as TRAINING_SUCCESS
from harness.text import shortened

ENV_STEPS = "environment steps"
LAST_100 = "a mean over the last 100 episodes"
ONE = "that of an episode"
NEW = "a mean over the episodes that ended since the point before"
LAST_100_OR_NEW = "a mean over the episodes of an iteration, or over the last 100"
EVALUATED = "a mean over the episodes of an evaluation"
TIME, ITERATION = "time", "iteration"
MOST_RESTARTS = 100
CLEANRL_RUN = re.compile(r"(?P<env>.+?)__(?P<algorithm>.+)__(?P<seed>\d+)__\d+")
"""What CleanRL calls a run, and its folder."""


class Curve(NamedTuple):
    """How one program logs one curve of returns.

    Attributes:
        program: Whose names these are.
        reward: The mean return; empty where only success is logged.
        success: Share of the episodes that succeeded; the first of these names that is there.
        length: Mean length of the episodes.
        time: Columns, or tags, that count environment steps over all envs; the first of these that is there.
        counts: What the step of an event counts, where no such tag is there.
        point: What a value is.
        evaluation: Whether the episodes are of evaluations.
        measure: One more measure, that a user names.
    """

    program: str
    reward: str
    success: tuple[str, ...] = ()
    length: str = ""
    time: tuple[str, ...] = ("global_step",)
    counts: str = ENV_STEPS
    point: str = LAST_100
    evaluation: bool = False
    measure: str = ""

    @property
    def columns(self) -> dict[str, str]:
        """By standard column: which of the log's names it is read from."""
        roles = {
            f"{REWARD}{RECORDED}": self.reward,
            f"{BEHAVIOUR}{SUCCESS}": next(iter(self.success), ""),
            "length": self.length,
            f"{BEHAVIOUR}{self.measure}": self.measure,
        }
        return {column: name for column, name in roles.items() if name}

    @property
    def main(self) -> str:
        """The name whose values are its points."""
        return next(iter(self.columns.values()))


RLLIB_STEPS = ("num_env_steps_sampled_lifetime", "timesteps_total", "num_env_steps_sampled")
RLLIB_SUCCESS = ("env_runners/success_rate", "custom_metrics/success_rate_mean", "custom_metrics/success_mean")
RLLIB = tuple(
    Curve(
        "RLlib, evaluations" if of else "RLlib",
        f"{prefix}{of}{reward}",
        tuple(f"{prefix}{of}{name}" for name in RLLIB_SUCCESS),
        f"{prefix}{of}{length}",
        tuple(f"{prefix}{name}" for name in RLLIB_STEPS),
        "environment steps or iterations, by its version",
        LAST_100_OR_NEW,
        bool(of),
    )
    for prefix in ("", "ray/tune/")
    for of in ("", "evaluation/")
    for reward, length in (
        ("env_runners/episode_return_mean", "env_runners/episode_len_mean"),
        ("env_runners/episode_reward_mean", "env_runners/episode_len_mean"),
        ("episode_reward_mean", "episode_len_mean"),
    )
)
CURVES = (
    Curve(
        "stable-baselines3",
        "rollout/ep_rew_mean",
        ("rollout/success_rate",),
        "rollout/ep_len_mean",
        ("time/total_timesteps", "global_step"),
    ),
    Curve(
        "stable-baselines3's EvalCallback",
        "eval/mean_reward",
        ("eval/success_rate",),
        "eval/mean_ep_length",
        ("time/total_timesteps", "global_step"),
        point=EVALUATED,
        evaluation=True,
    ),
    Curve("CleanRL", "charts/episodic_return", (), "charts/episodic_length", point=ONE),
    Curve("this project's tracker", RETURN, (TRAINING_SUCCESS,), time=("steps",)),
    Curve(
        "this project's tracker, evaluations",
        "Evaluation/Cumulative Reward",
        ("Evaluation/Success Rate",),
        time=("steps",),
        point=EVALUATED,
        evaluation=True,
    ),
    Curve("Unity ML-Agents", "Environment/Cumulative Reward", (), "Environment/Episode Length", point=NEW),
    Curve(
        "rsl_rl, as in Isaac Lab",
        "Train/mean_reward",
        ("Metrics/success_rate",),
        "Train/mean_episode_length",
        counts="iterations",
    ),
    Curve("rl_games", "rewards/step", (), "episode_lengths/step"),
    Curve(
        "skrl",
        "Reward / Total reward (mean)",
        (),
        "Episode / Total timesteps (mean)",
        counts="steps of each of its envs",
    ),
    *RLLIB,
    Curve("Spinning Up", "AverageEpRet", (), "EpLen", ("TotalEnvInteracts",), point=NEW),
    Curve(
        "Spinning Up, tests",
        "AverageTestEpRet",
        (),
        "TestEpLen",
        ("TotalEnvInteracts",),
        point=EVALUATED,
        evaluation=True,
    ),
    Curve("baselines", "eprewmean", (), "eplenmean", ("misc/total_timesteps", "total_timesteps")),
    Curve("baselines", "EpRewMean", (), "EpLenMean", ("TimestepsSoFar",)),
    Curve(
        "garage",
        "Evaluation/AverageReturn",
        ("Evaluation/SuccessRate",),
        "",
        ("TotalEnvSteps",),
        point=EVALUATED,
        evaluation=True,
    ),
)
"""Every curve that is known by its names. Of those that a log has, one with success goes before one without, and one of
the training before one of evaluations."""


@dataclass(frozen=True)
class CurveSettings:
    """What a user can say of a log of curves.

    Attributes:
        reward: The column, or tag, of mean returns; found by its name if empty.
        success: That of the share of episodes that succeeded; found by its name if empty.
        length: That of mean lengths; found by its name if empty.
        measure: That of one more measure, which no reward enters.
        per_step: Environment steps of one of its steps, where these are iterations; 0 if nobody says.
        episode: Steps of an episode at most, where values average so many episodes and no lengths stand beside them; 0
            if nobody says.
    """

    reward: str = ""
    success: str = ""
    length: str = ""
    measure: str = ""
    per_step: int = 0
    episode: int = 0

    def chosen(self, path: Path, names: Sequence[str]) -> Curve:
        """The curve to read among the names of a log.

        Raises:
            UsageError: A name that was given is not there, or none is known.
        """
        require_columns(path, names, self.reward, self.success, self.length, self.measure)
        there = [curve for curve in CURVES if curve.reward in names]
        by_success = [curve._replace(reward="") for curve in CURVES if set(curve.success) & set(names)]
        if self.reward:
            known = next((curve for curve in there if curve.reward == self.reward), None)
            curve = known or Curve("", self.reward, counts="steps of its own", point="")
        elif there or by_success:
            curve = min(there or by_success, key=lambda it: (not set(it.success) & set(names), it.evaluation))
        elif self.success:
            curve = Curve("", "", counts="steps of its own", point="")
        else:
            raise UsageError(
                f"{path} has no curve of returns that is known by its name: say reward=NAME. "
                f"It has: {shortened(', '.join(names), 160)}"
            )
        success = self.success or next((name for name in curve.success if name in names), "")
        length = self.length or (curve.length if curve.length in names else "")
        return curve._replace(success=(success,) if success else (), length=length, measure=self.measure)


def is_known(names: Iterable[str]) -> bool:
    """Whether a curve is known by one of these names."""
    there = set(names)
    return any(curve.reward in there or there & set(curve.success) for curve in CURVES)


def is_history(names: Iterable[str]) -> bool:
    """Whether a table is the history of a run of Weights & Biases, which has the names of whatever logged into it."""
    return {"_step", "_timestamp"} <= set(names)


def curve_log(
    facts: LogFacts, curve: Curve, names: Sequence[str], columns: Mapping[str, Float], settings: CurveSettings
) -> Log:
    """The log of one curve.

    Args:
        facts: Of the file.
        curve: Which of its names to read, see `CurveSettings.chosen`.
        names: All that the log has, to tell what else is there.
        columns: By name, (points,) each, and ``step``, what its own steps count; NaN where a point lacks a value.
        settings: What a user said.

    Raises:
        UsageError: The log tells environment steps itself, and a user says how many one of its steps is.
        SchemaError: No point has all of its values, one is beyond what it can be, or its steps go back too often.
    """
    per_step, counter = settings.per_step, _counter(curve, columns)
    if per_step and counter != "step":
        raise UsageError(f"{facts.path} counts environment steps in '{counter}': leave per_step out")
    is_time = counter != "step" or curve.counts == ENV_STEPS or per_step > 0
    axis = TIME if is_time else ITERATION
    read = {axis: counter, **_read(curve, columns)}
    whole = ~np.isnan(np.stack([columns[name] for name in read.values()])).any(axis=0)
    lacking = int((~np.isnan(columns[curve.main])).sum() - whole.sum())
    rows, restarts = _last_attempt(facts.path, np.flatnonzero(whole), columns[counter][whole])
    if not len(rows):
        raise SchemaError(f"{facts.path} has no point of {', '.join(curve.columns.values())} yet")
    found = {column: columns[name][rows] for column, name in read.items()}
    if per_step:
        found[axis] = found[axis] * per_step
    steps = columns[curve.length][rows] if curve.length else np.full(len(rows), np.nan)
    is_told = ~np.isnan(steps)
    if is_told.any():
        steps = np.interp(found[axis], found[axis][is_told], steps[is_told])
    elif settings.episode:
        steps = np.full(len(rows), float(settings.episode))
    found[SINCE] = _since(curve.point, found[axis], steps if is_time else np.full(len(rows), np.nan))
    _require_possible(facts.path, found)
    told = ", ".join(f"{column} from '{name}'" for column, name in read.items() if column != axis)
    others = [it.reward for it in CURVES if it.reward in names and it.reward != curve.reward]
    notes = {
        f"{told}; {axis} from " + ("its steps" if counter == "step" else f"'{counter}'"): True,
        f"its steps are {curve.counts}: per_step=N says how many environment steps one is": not is_time,
        f"'{curve.length}' lacks values: it is left out": curve.length and "length" not in read,
        f"{lacking} points that lack one of these are left out": lacking,
        f"{restarts} times it goes back: what was logged again later counts": restarts,
        f"there are also curves of {', '.join(others)}": others,
    }
    point = f"each value is {curve.point}" if curve.point not in ("", ONE) else ""
    facts = replace(
        facts,
        unit="point",
        evaluation=curve.evaluation,
        bounds={SUCCESS: (0.0, 1.0)} if curve.success else {},
        thinned="; ".join(filter(None, [facts.thinned, point])),
        notes=(*facts.notes, *(note for note, is_so in notes.items() if is_so)),
    )
    return in_memory(facts, found)


def _counter(curve: Curve, columns: Mapping[str, Float]) -> str:
    """What counts environment steps wherever the curve has a point; else ``step``, or what else there is."""
    is_point = ~np.isnan(columns[curve.main])
    there = [name for name in curve.time if name in columns]
    filled = (name for name in there if not np.isnan(columns[name][is_point]).all())
    return next(filled, "step" if "step" in columns else there[0])


def _read(curve: Curve, columns: Mapping[str, Float]) -> dict[str, str]:
    """By standard column: the name that it is read from. Lengths are left out where points have none."""
    read = dict(curve.columns)
    length = read.pop("length", "")
    whole = ~np.isnan(np.stack([columns[name] for name in (read or curve.columns).values()])).any(axis=0)
    if length and not np.isnan(columns[length][whole]).any():
        read["length"] = length
    return read


def _since(point: str, after: Float, length: Float) -> Float:
    """Steps before the first episode that each value averages, (points,); NaN where nobody knows.

    Args:
        point: What a value is.
        after: Steps when each was told.
        length: Mean lengths of the episodes; NaN where nobody knows.
    """
    before = np.concatenate([[0.0], after[:-1]])
    last_100: Float = np.maximum(after - 100.0 * length, 0.0)
    known: dict[str, Float] = {
        EVALUATED: after,
        NEW: before,
        ONE: np.where(np.isnan(length), before, np.maximum(after - length, 0.0)),
        LAST_100_OR_NEW: np.minimum(before, last_100),
    }
    return known.get(point, last_100)


def _last_attempt(path: Path, rows: Ints, steps: Float) -> tuple[Ints, int]:
    """Which rows count, where some were logged again after a restart: the later ones; and how many restarts."""
    kept = np.ones(len(steps), bool)
    back = np.flatnonzero(np.diff(steps) < 0.0) + 1
    if len(back) > MOST_RESTARTS:
        raise SchemaError(f"{path}: its steps go back {len(back):,} times: several trainings write to it, or none")
    for row in back:
        kept[:row] &= steps[:row] < steps[row]
    return rows[kept], len(back)


def _require_possible(path: Path, columns: Mapping[str, Float]) -> None:
    for name, values in columns.items():
        low, high = (0.0, 1.0) if name == f"{BEHAVIOUR}{SUCCESS}" else (-LARGEST, LARGEST)
        wrong = (values < low) | (values > high)
        if wrong.any():
            shown = float(values[int(np.argmax(wrong))])
            raise SchemaError(f"{path}: a value of {name} is {shown:g}; it lies from {low:g} to {high:g}")
