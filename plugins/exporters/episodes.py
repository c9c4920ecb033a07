"""Episodes of an experiment, or of recorded trainings, as data sets of other programs take them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.authoring.commands import (
    BEHAVIOUR,
    EVALUATION,
    EVALUATION_RECORDING,
    FLAGS,
    REWARD,
    TRACE,
    TRAINING_RECORDING,
    Cell,
    Choice,
    Group,
    PayAgain,
    Registry,
    Walk,
    episode_facts,
    episode_rows,
    facts_of,
    needs_of,
    pay_log,
    read_recording,
    read_trace,
    recordings_in,
    term_column,
)
from harness.errors import HarnessError, UsageError
from harness.log import Log, Rows
from harness.results import Results
from harness.text import file_stems

Nested: TypeAlias = Any
"""Rows of an observation or an action: an array (rows, ...), or a dict or a tuple of `Nested`."""
TRAINING, EVALUATED = "training", "evaluation"
TERMS = "harness_terms"
"""The key of the metadata that tells, by column, which term of which reward it is."""
PERIOD = 0.1
"""What the time between two steps is taken for where nobody tells it, [s]."""
AXES = ("x", "y", "z")


class Term(NamedTuple):
    """A term of a reward."""

    reward: str
    """The label of the reward."""
    name: str

    @property
    def title(self) -> str:
        """What it is called, ``gentle/effort``."""
        return f"{self.reward}/{self.name}"


@dataclass(frozen=True, eq=False)
class Exported:
    """One episode.

    Attributes:
        observations: Before each step and after the last: `Nested` of steps + 1 rows.
        actions: (steps, ...).
        rewards: What the learner was paid, (steps,).
        paid: By label, what rewards pay, (steps,).
        terms: By `Source.terms`, what a term of a reward pays, (steps,).
        infos: By key, what was measured after each step, (steps,).
        success: Whether each step was a success, (steps,); None where nothing says it.
        terminated: Whether each step ended the episode, (steps,).
        truncated: Whether it was cut there, (steps,).
        operator: The training whose policy acted.
    """

    observations: Nested
    actions: NDArray[Any]
    rewards: Float
    paid: Mapping[str, Float]
    terms: Mapping[Term, Float]
    infos: Mapping[str, Float]
    success: Mask | None
    terminated: Mask
    truncated: Mask
    operator: str


@dataclass(frozen=True)
class Source:
    """The episodes of one data set.

    Attributes:
        name: What it is called, without the version.
        rewards: Labels of all rewards whose columns its episodes have, in order.
        terms: The terms of these rewards, in order.
        robot: The robot, or the environment.
        names: By column, ``observation`` and ``action``, what its numbers are called; empty if nobody says it.
        period: Time between two steps, [s].
        left_out: Why rewards are missing, a line each; filled while episodes are read.
    """

    name: str
    rewards: tuple[str, ...]
    terms: tuple[Term, ...]
    robot: str
    names: Mapping[str, tuple[str, ...]]
    period: float
    _episodes: Any
    left_out: list[str] = field(default_factory=list)

    def episodes(self) -> Iterator[Exported]:
        """All of them; a training is read at a time."""
        yield from self._episodes()


def sources_of_runs(results: Results, registry: Registry) -> Iterator[Source]:
    """A data set of trainings and one of evaluations for each group of cells that are done."""
    for stem, (group, cells) in zip(file_stems(map(_text, results.groups)), results.groups.items(), strict=True):
        labels = dict.fromkeys(cell.reward for cell in cells)
        if cells[0].is_in_environment:
            again = PayAgain(registry)
            for kind, inner in ((TRAINING, TRAINING_RECORDING), (EVALUATED, EVALUATION_RECORDING)):
                places = [(results.store.cell_folder(cell) / inner, cell) for cell in cells]
                yield _of_recordings(f"{stem}/{kind}", places, again, cells[0].task.label)
            continue
        left_out: list[str] = []
        rewards = dict(_built(labels, registry, left_out))
        first = results.store.cell_folder(cells[0])
        for kind, file in ((TRAINING, TRACE), (EVALUATED, EVALUATION)):
            trace = read_trace(first / file)
            yield Source(
                f"{stem}/{kind}",
                tuple(rewards),
                tuple(Term(label, name) for label, reward in rewards.items() for name in needs_of(reward).terms),
                group.labels["robot"].rsplit("/")[-1],
                _names_of_arm(trace),
                episode_facts(trace).control_period or PERIOD,
                lambda file=file, cells=cells, rewards=rewards: (
                    episode
                    for cell in cells
                    for episode in _of_trace(results.store.cell_folder(cell) / file, cell, rewards)
                ),
                left_out,
            )


def source_of_recordings(folder: Path, registry: Registry) -> Source:
    """All recordings in a folder that is no experiment's as one data set."""
    again = PayAgain(registry)
    found: list[tuple[Path, Cell | None]] = [(path, None) for path in sorted(recordings_in(folder))]
    return _of_recordings(file_stems([folder.resolve().name])[0], found, again, "")


def _text(group: Group) -> str:
    return " ".join(label.rsplit("/")[-1] if kind == "robot" else label for kind, label in group.labels.items())


def _built(choices: Mapping[Choice, None], registry: Registry, left_out: list[str]) -> Iterator[tuple[str, Any]]:
    for choice in choices:
        try:
            yield choice.label, choice.build(registry, "rewards")
        except HarnessError as error:  # one that is not installed any more
            left_out.append(f"reward {choice.label} is left out: {error} If it stands in a file, add --plugin FILE")


def _names_of_arm(trace: Log) -> dict[str, tuple[str, ...]]:
    joints = tuple(f"joint_{number}" for number in range(trace["qpos"].shape[1]))
    places = tuple(f"{what}_{axis}" for what in ("end_effector", "target") for axis in AXES)
    actions = tuple(f"action_{number}" for number in range(trace["action"].shape[1]))
    return {"observation": (*joints, *places), "action": actions}


def _of_trace(path: Path, cell: Cell, rewards: Mapping[str, Any]) -> Iterator[Exported]:
    """Episodes of an arm: joints [rad], end effector and target [m]; an episode that was not finished counts too."""
    trace = read_trace(path)
    positions = [trace[f"{what}_{axis}"][:, None] for what in ("end_effector", "target") for axis in AXES]
    seen = np.hstack([trace["qpos"], *positions])
    paid = {label: pay_log(reward, trace) for label, reward in rewards.items()}
    events = trace["reward_ground"] + trace["reward_target"] + trace["reward_step"]
    whole = trace["reward"] + events
    for rows in episode_rows(trace["env"], trace["episode"]):
        steps = rows[1:]
        if not len(steps) or trace["step"][rows[0]] != 0:
            continue
        yield Exported(
            seen[rows],
            trace["action"][steps],
            whole[steps],
            {label: found.total[steps] for label, found in paid.items()},
            {Term(label, name): it[steps] for label, found in paid.items() for name, it in found.terms.items()},
            {"reward_events": events[steps], "distance": trace["distance"][steps]},
            trace["reached"][steps],
            trace["terminated"][steps],
            trace["truncated"][steps],
            f"{cell.reward.label} seed {cell.seed}",
        )


def _of_recordings(name: str, places: Sequence[tuple[Path, Cell | None]], again: PayAgain, env: str) -> Source:
    logs = [read_recording(path) for path, _ in places]
    facts = [facts_of(log) for log in logs]
    told = dict.fromkeys(label for it in facts for label in it.rewards)
    rewards = tuple(label for label in told if _is_known(logs, label))
    left_out = [f"reward {label} is left out: it is not known in every step" for label in sorted({*told} - {*rewards})]
    first = facts[0].terms
    alike = [label for label in rewards if all(it.terms.get(label) == first.get(label) for it in facts)]
    terms = tuple(Term(label, name) for label in alike for name in first.get(label, ()))

    def episodes() -> Iterator[Exported]:
        for (path, cell), log in zip(places, logs, strict=True):
            task = None if cell is None else cell.task
            who = path.name if cell is None else f"{cell.reward.label} seed {cell.seed}"
            rows = log.rows(["env", "episode", *FLAGS, *facts_of(log).numbers, *(term_column(*it) for it in terms)])
            known = [it for it in log.measures if not np.isnan(rows[f"{BEHAVIOUR}{it}"]).any()]
            for number, walks in again.walks(path, task):
                for steps, walk in zip(_split(rows.part(rows["env"] == number)), walks, strict=True):
                    yield _of_walk(steps, walk, log.facts.trained_with, rewards, terms, known, who)

    return Source(name, rewards, terms, env or facts[0].env, {}, PERIOD, episodes, left_out)


def _is_known(logs: Sequence[Log], label: str) -> bool:
    column = f"{REWARD}{label}"
    return all(column in log and not np.isnan(log.rows([column])[column]).any() for log in logs)


def _split(rows: Rows) -> list[Rows]:
    """The episodes of one env."""
    ends = [*(np.flatnonzero(np.diff(rows["episode"])) + 1).tolist(), len(rows)]
    return [rows.part(slice(begin, end)) for begin, end in zip([0, *ends], ends, strict=False) if begin < end]


def _of_walk(
    rows: Rows,
    walk: Walk,
    trained_with: str,
    rewards: tuple[str, ...],
    terms: tuple[Term, ...],
    known: list[str],
    who: str,
) -> Exported:
    infos = {name: rows[f"{BEHAVIOUR}{name}"] for name in known}
    success = next((infos[name] for name in ("success", "is_success") if name in infos), None)
    return Exported(
        stacked(walk.states),
        np.asarray(walk.actions),
        rows[f"{REWARD}{trained_with}"],
        {label: rows[f"{REWARD}{label}"] for label in rewards},
        {term: rows[term_column(*term)] for term in terms},
        infos,
        None if success is None else success > 0.0,
        rows["terminated"],
        rows["truncated"],
        who,
    )


def stacked(states: Any) -> Nested:
    """Observations, one after the other, as rows.

    Raises:
        UsageError: They are no numbers.
    """
    first = states[0]
    if isinstance(first, Mapping):
        return {key: stacked([state[key] for state in states]) for key in first}
    if isinstance(first, tuple):
        return tuple(stacked([state[place] for state in states]) for place in range(len(first)))
    rows = np.asarray(states)
    if rows.dtype.kind not in "biuf":
        raise UsageError(f"Observations of {rows.dtype} are no numbers: they cannot be written as a data set")
    return rows
