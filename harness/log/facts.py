"""What is known of a training beside the rows of its log, whatever program wrote it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

Unit: TypeAlias = Literal["step", "episode", "point"]
"""What a row of a log is: an environment step, an episode, or a point of a curve, such as a mean over some episodes."""


@dataclass(frozen=True)
class Failed:
    """A reward or a measure that was given up on the way: from some row on its column holds NaN.

    Attributes:
        column: Its column.
        reason: One line.
    """

    column: str
    reason: str

    @property
    def told(self) -> str:
        """The reason in words; a subclass may know where it was given up."""
        return f"given up: {self.reason}"


@dataclass(frozen=True, kw_only=True)
class LogFacts:
    """What is known of one training beside its rows. A field that a log does not tell keeps its default.

    Attributes:
        path: The file or the folder that was read.
        format: Format and version, in words, ``Monitor of stable-baselines3``.
        reader: The name under which the format is registered, to type ``--as NAME:...``; `harness.log.open_log` knows.
        unit: What a row is.
        first_line: Where the first row stands in its file, for what is said of a row: the line of a text.
        run: What the file itself calls the training, where it holds several.
        trained_with: The name of the reward that the learner was paid.
        env: The id of the environment, or its specification as text. It is never run.
        algorithm: What learned.
        seed: Of the training.
        started: When it began, in seconds of Unix time; None if nobody says.
        evaluation: Whether the rows are of evaluations of a policy, in which nothing was trained.
        asked: Environment steps that the training was to take; 0 if nobody said.
        declared: Totals that the file tells of itself, by ``steps``, ``episodes``, ``tasks``.
        lower_is_better: Measures of which less is better.
        higher_is_better: Those of which somebody said that more is.
        bounds: By measure, the least and the greatest value that it can have; either may be infinite.
        thinned: Why the rows are not all that there were, or not as they were measured, as ``TensorBoard keeps ...``.
        failed: Rewards and measures that were given up on the way.
        notes: What to keep in mind, a line each.
    """

    path: Path
    format: str
    reader: str = ""
    unit: Unit = "step"
    first_line: int = 1
    run: str = ""
    trained_with: str = ""
    env: str = ""
    algorithm: str = ""
    seed: int | None = None
    started: float | None = None
    evaluation: bool = False
    asked: int = 0
    declared: Mapping[str, int] = field(default_factory=dict)
    lower_is_better: tuple[str, ...] = ()
    higher_is_better: tuple[str, ...] = ()
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    thinned: str = ""
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()
