"""What is known of a recorded training beside its steps, as ``recording-<n>.json`` tells it."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, Self

from pydantic import AfterValidator, Field, with_config
from typing_extensions import TypedDict

from harness.eta.manner import Acted
from harness.files.bounded import read_sealed, reading, seal
from harness.files.plain import Plain
from harness.log import Failed, Log, LogFacts
from harness.log.log import BEHAVIOUR, REWARD
from harness.record.file_forms import EXACT, Digest, Line, Name, Number, Whole, read_form

FORMAT = 2
"""Since format 2 a recording may hold the actions."""
MOST_NAMES = 1_000
"""The most rewards, and the most measures of behaviour."""
MOST_ENVS = 1_000_000
MOST_NOTES = 10 * MOST_NAMES
MOST_SOURCE = 100_000
"""Characters of a reward's code that are kept."""
MOST_ACTION_NUMBERS = 256
"""An action with more numbers is not recorded: a recording would mostly consist of actions."""
OWN_SOURCE = "what the env pays"
"""The source of a reward that is no function."""
FILE_REWARD, FILE_BEHAVIOUR = "reward_", "behaviour_"
"""What the columns of rewards and of measures begin with in the files, and in what a recorder tells."""
RECORDER = "recording of harness"
"""The format of the facts of recordings."""


def term_column(reward: str, term: str) -> str:
    """The column of a term of a reward, in files too."""
    return f"{REWARD}{reward}/{term}"


def file_column(column: str) -> str:
    """What the column of a log, ``reward/v1``, is called in files, ``reward_v1``; it is none of a term."""
    return column.replace("/", "_", 1) if column.startswith((REWARD, BEHAVIOUR)) else column


def log_column(column: str) -> str:
    """What the column of a file, ``reward_v1``, is called in a log, ``reward/v1``."""
    return column.replace("_", "/", 1) if column.startswith((FILE_REWARD, FILE_BEHAVIOUR)) else column


def _distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    if len({*names}) < len(names):
        raise ValueError("a name stands twice")
    return names


def _small(shape: tuple[int, ...]) -> tuple[int, ...]:
    if (count := math.prod(shape)) > MOST_ACTION_NUMBERS:
        raise ValueError(f"an action has {count:,} numbers, {MOST_ACTION_NUMBERS} are allowed")
    return shape


LogColumn = Annotated[Name, AfterValidator(log_column)]
"""A column as logs call it; files tell it as `file_column` does."""
Names = Annotated[tuple[Name, ...], Field(max_length=MOST_NAMES), AfterValidator(_distinct)]


@with_config(EXACT)
@dataclass(frozen=True)
class Source:
    """The code of a reward or of a measure.

    Attributes:
        sha256: Of the code in UTF-8; empty where Python cannot tell it.
        text: The code, its first 100,000 characters: Python code, or what was given in its
            place: ``info key 'distance'``, ``what the env pays``.
    """

    sha256: Digest | Literal[""]
    text: Annotated[str, Field(max_length=MOST_SOURCE)]


@with_config(EXACT)
@dataclass(frozen=True)
class Failure(Failed):
    """A reward or a measure that was given up in the middle of a training: from this step on it is NaN in all envs.

    Attributes:
        env: Where it failed.
        episode: Counted from 0 in that env.
        step: Counted from 0 in that episode.
    """

    column: LogColumn
    reason: Line
    env: Whole
    episode: Whole
    step: Whole

    @property
    def told(self) -> str:
        """Where and why it was given up."""
        return f"given up in step {self.step:,} of episode {self.episode:,}: {self.reason}"

    def to_json(self) -> dict[str, Any]:
        """Plain data, as files have it."""
        return {**asdict(self), "column": file_column(self.column)}


@with_config(EXACT)
@dataclass(frozen=True)
class ActionFacts(Plain):
    """How the actions of a training are recorded, so that another env can be given the same ones.

    Attributes:
        shape: Of an action.
        type: Of an action as the learner gave it: the name of a NumPy type, or ``python int``, ``python float``,
            ``python bool``. Empty before the first step.
        problem: Why an env cannot be given the same actions; empty if it can. One line.
    """

    shape: Annotated[tuple[Annotated[int, Field(gt=0)], ...], Field(max_length=32), AfterValidator(_small)]
    type: Line = ""
    problem: Line = ""

    @property
    def size(self) -> int:
        """How many numbers an action has."""
        return math.prod(self.shape)


@dataclass(frozen=True, kw_only=True)
class TrainingFacts(LogFacts):
    """What is known of a recorded training beside its steps.

    Attributes:
        trained_with: The one of the rewards that the learner was paid.
        seed: The first that the env was reset with; None if it was given none.
        evaluation: Whether a finished policy acted, and nothing was trained: `trained_with` and `seed` are then those
            of the training that it comes from.
        notes: What was told of rewards and measures that are recorded: that they draw, or remember. A line each.
        rewards: Names of the rewards that scored its steps.
        behaviour: Names of measures of what the robot did; no reward enters them.
        pay: Whether the recorder paid the learner `trained_with`: what the env itself pays does not depend on what
            taught then.
        num_envs: How many envs were stepped.
        seeds: Those of a batch of envs, where they differ.
        spec: ``id``, ``kwargs`` and more of the env's Gymnasium spec; empty if it has none.
        versions: Of the libraries, by distribution.
        sources: By column (``reward/v1``, ``behaviour/success``): the code behind it.
        paid_otherwise: The first step in which the env paid something else than the reward `trained_with`; empty if
            there is none, or the env's own payment is that reward. One line.
        closed: Whether the training ended by itself; otherwise it is still going on, or was killed.
        actions: How its actions are recorded; None if they are not.
        horizon: After how many steps an episode was cut; 0 if only the env itself ended episodes.
        cut: How many episodes were cut so.
        acted: Of an evaluation: how actions were chosen.
        after: Of an evaluation: environment steps of training before it; 0: the training had ended.
        episodes_asked: Of an evaluation: how many episodes it was to take; 0: nobody said.
        starts: Of an evaluation in a single env: a checksum of the first observations of its episodes, in order. It
            is 0 before the first episode, and where a wrapper normalises observations by those seen before.
        terms: By name of a reward that pays terms: what they are called, in the order in which they are summed.
    """

    path: Path = Path()
    format: str = RECORDER
    rewards: tuple[str, ...]
    behaviour: tuple[str, ...] = ()
    pay: bool = False
    num_envs: int = 1
    seeds: tuple[int | None, ...] = ()
    spec: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    sources: Mapping[str, Source] = field(default_factory=dict)
    paid_otherwise: str = ""
    closed: bool = False
    actions: ActionFacts | None = None
    horizon: int = 0
    cut: int = 0
    acted: Acted = ""
    after: int = 0
    episodes_asked: int = 0
    starts: int = 0
    terms: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def failures(self) -> tuple[Failure, ...]:
        """Those of `failed` of which the place is known: of a recording all."""
        return tuple(it for it in self.failed if isinstance(it, Failure))

    @property
    def term_columns(self) -> dict[str, str]:
        """By the column of each term, ``reward/gentle/effort``, the column of the reward that it is a term of."""
        return {term_column(it, term): f"{REWARD}{it}" for it in self.rewards for term in self.terms.get(it, ())}

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the columns that hold numbers: of the rewards, then of the measures."""
        return (*(f"{REWARD}{name}" for name in self.rewards), *(f"{BEHAVIOUR}{name}" for name in self.behaviour))

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        named = {
            # JSON has no infinite numbers
            "bounds": {name: [end if math.isfinite(end) else None for end in of] for name, of in self.bounds.items()},
            "seed": self.seeds or self.seed,
            "env": self.spec,
            "sources": {file_column(column): asdict(source) for column, source in self.sources.items()},
            "failures": [failure.to_json() for failure in self.failures],
            "actions": self.actions and self.actions.to_json(),
            "steps_asked": self.asked,
        }
        told = {name: named[name] if name in named else getattr(self, name) for name in KEYS}
        return {name: value for name, value in told.items() if value or name in RecordingForm.__required_keys__}

    def write(self, path: Path) -> None:
        """Write them into a file of their own; the writer of the recording puts it in its place whole.

        Raises:
            OSError: The file cannot be written.
        """
        path.write_bytes(seal({"format": FORMAT, **self.to_json()}))

    @classmethod
    def read(cls, path: Path) -> Self:
        """What `write` wrote.

        Raises:
            SchemaError: It is damaged, or no such file.
            NewerFormat: A newer version wrote it.
        """
        data = read_sealed(path, "recording", newest=FORMAT, since=1)
        with reading(path, "recording"):
            del data["format"]
            return cls.from_json(data, path.parent)

    @classmethod
    def from_json(cls, data: Mapping[str, Any], folder: Path = Path()) -> Self:
        """What `to_json` told of the recording in a folder, also after a way through JSON.

        Raises:
            ValueError: It has another form.
        """
        told: Mapping[str, Any] = read_form(RecordingForm, data)
        seed = told["seed"]
        if told["trained_with"] not in told["rewards"]:
            raise ValueError(f"it was trained with {told['trained_with']!r}, which is none of its rewards")
        seeds = seed if isinstance(seed, tuple) else ()
        return cls(**{
            **{name: told[name] for it in fields(cls) if (name := it.name) in told},
            "path": folder,
            "bounds": {
                name: (-math.inf if low is None else low, math.inf if high is None else high)
                for name, (low, high) in told.get("bounds", {}).items()
            },
            "seed": next((it for it in seeds if it is not None), None) if seeds else seed,
            "seeds": seeds,
            "env": str(told["env"].get("id") or ""),
            "spec": told["env"],
            "failed": told["failures"],
            "asked": told.get("steps_asked", 0),
        })  # fmt: skip


def facts_of(log: Log) -> TrainingFacts:
    """The facts of a log as those of a recording; what only a recorder knows stays at its default."""
    if isinstance(log.facts, TrainingFacts):
        return log.facts
    known = {it.name: getattr(log.facts, it.name) for it in fields(LogFacts)}
    terms = {name: of for name in log.rewards if (of := log.terms_of(name))}
    return TrainingFacts(**known, rewards=log.rewards, behaviour=log.measures, closed=True, terms=terms)


@with_config(EXACT)
class RecordingForm(TypedDict):
    """The file of `TrainingFacts` but for its format; the keys are written in this order."""

    rewards: Names
    trained_with: Name
    behaviour: Names
    lower_is_better: Names
    pay: NotRequired[bool]
    bounds: NotRequired[dict[Name, tuple[Number | None, Number | None]]]
    evaluation: bool
    num_envs: Annotated[int, Field(gt=0, le=MOST_ENVS)]
    seed: Whole | Annotated[tuple[Whole | None, ...], Field(max_length=MOST_ENVS)] | None
    env: dict[Name, Any]
    versions: dict[Name, Line]
    sources: dict[LogColumn, Source]
    failures: Annotated[tuple[Failure, ...], Field(max_length=2 * MOST_NAMES)]
    paid_otherwise: Line
    closed: bool
    actions: NotRequired[ActionFacts | None]
    horizon: NotRequired[Whole]
    cut: NotRequired[Whole]
    acted: NotRequired[Acted]
    after: NotRequired[Whole]
    notes: NotRequired[Annotated[tuple[Line, ...], Field(max_length=MOST_NOTES)]]
    steps_asked: NotRequired[Whole]
    episodes_asked: NotRequired[Whole]
    starts: NotRequired[Whole]
    higher_is_better: NotRequired[Names]
    terms: NotRequired[dict[Name, Names]]


KEYS = tuple(RecordingForm.__annotations__)
"""The keys of the file in order, without its format."""
