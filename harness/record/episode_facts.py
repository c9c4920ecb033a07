"""What is known of a trace's episodes beside its rows."""

import json
from dataclasses import dataclass, replace
from typing import Self

from harness.files.plain import Plain
from harness.log import Log, LogFacts

LATER = ("arms", "error", "unit", "target_moves")
"""Left out of the file where there is nothing to tell: it stays, byte for byte, as it was before there were any."""


@dataclass(frozen=True)
class EpisodeFacts(Plain):
    """Facts that metrics need and that no row tells; None where the file says nothing, as those of version 0.1.

    Attributes:
        horizon: An episode is truncated after so many environment steps.
        control_period: Duration of an environment step, [s].
        ik_steps: Of an evaluation: the environment steps that the arm's own kinematics take to the target, by env, from
            the same start in the same simulator; None of an env where they do not reach it. None altogether where they
            cannot act, see `harness.env.arm_observation`.
        work: Of an evaluation: the mechanical work of each env's episode, see `harness.robot.energy`, [J]. None where
            the arm jumps from pose to pose or its links have no mass.
        arms: Where the arms of episodes differ, how: for each arm the factors of the masses of the links that move,
            those of their sizes, and that of the friction of the drives; 1 is as drawn. The column `arm` of a row is
            the number of its episode's. None where they do not differ.
        error: What the columns of distances hold, of a task that asks for more than a point that stays, as ``pose
            error``; None of one that does not: the distance from end effector to target, in metres.
        unit: Of the error.
        target_moves: True of a task whose target moves.
    """

    horizon: int | None = None
    control_period: float | None = None
    ik_steps: tuple[int | None, ...] | None = None
    work: tuple[float, ...] | None = None
    arms: tuple[tuple[tuple[float, ...], tuple[float, ...], float], ...] | None = None
    error: str | None = None
    unit: str | None = None
    target_moves: bool | None = None

    def to_bytes(self) -> bytes:
        """For a file; `from_bytes` gives the same facts back."""
        told = {name: value for name, value in self.to_json().items() if value is not None or name not in LATER}
        return json.dumps(told).encode()

    @classmethod
    def from_bytes(cls, text: bytes) -> Self:
        """What `to_bytes` wrote; facts that a newer version added are left out.

        Raises:
            ValueError: It is something else.
        """
        data = json.loads(text)
        if not isinstance(data, dict):
            raise ValueError(f"facts are {data!r}")
        return cls.from_json(data)


NOTHING_KNOWN = EpisodeFacts()


@dataclass(frozen=True, kw_only=True)
class TraceFacts(LogFacts):
    """What is known of a trace beside its rows.

    Attributes:
        episodes: What is known of its episodes.
    """

    episodes: EpisodeFacts = NOTHING_KNOWN


def episode_facts(log: Log) -> EpisodeFacts:
    """What is known of the episodes of a log; nothing, of one that is no trace."""
    return log.facts.episodes if isinstance(log.facts, TraceFacts) else NOTHING_KNOWN


def with_episode_facts(trace: Log, facts: EpisodeFacts) -> Log:
    """The same trace of whose episodes something else is known."""
    return replace(trace, facts=TraceFacts(**{**vars(trace.facts), "episodes": facts}))
