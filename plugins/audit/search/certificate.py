"""One behaviour that a search found, as a file that anybody can play again: what was done, and what that is paid.

A file holds names and numbers, never code. It may come from a stranger, so that it is checked before it is used.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, with_config
from typing_extensions import TypedDict

from harness import Float, Mask
from harness.eta import mean_over_seeds
from harness.eta.headline import estimate_text
from harness.files import reading
from harness.files.bounded import read_sealed, seal, write_whole
from harness.files.plain import to_plain
from harness.log.log import LARGEST, episode_sum
from harness.record.file_forms import EXACT, OPEN, Name, Whole, read_form, told_as
from harness.text import file_stems

from .behaviour import Role
from .film import Film
from .place import Place, Text
from .world import Data, Shown, since

FORMAT = 1
NOUN = "certificate"
BEGINS = f'{{\n "format": {FORMAT},\n "what": "{NOUN}"'.encode()
"""The first bytes of a file."""
MOST_BYTES = 16 * 2**20
"""The most bytes of a file; one of 200 steps has 30,000."""
MOST_STEPS, MOST_NUMBERS, MOST_NAMED = 20_000, 500_000, 100
"""The most steps, numbers of all actions, and terms or measures."""
DRAWN = {"time", "qpos", "target", "distance"}
"""What an arm is drawn from; see `Shown`."""

ROUNDING = 1e-9
"""By so much of what was paid a sum may differ from that of its steps: versions add in other orders."""
Number = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Row = Annotated[list[Number], Field(max_length=MOST_STEPS)]
Steps = Annotated[Float, told_as(Annotated[Row, Field(min_length=1)], partial(np.array, dtype=float))]
Untold = Annotated[
    Float, told_as(Annotated[list[Number | None], Field(max_length=MOST_STEPS)], partial(np.array, dtype=float))
]
Flags = Annotated[
    Mask, told_as(Annotated[list[Literal[0, 1]], Field(max_length=MOST_STEPS)], partial(np.array, dtype=bool))
]
Size = Annotated[int, Field(ge=1, le=MOST_NUMBERS)]
FEW = Field(max_length=MOST_NAMED)


class AnswerForm(TypedDict):
    """What the search said of the reward, see `Finding`; on how many starts the alarm holds, of how many."""

    word: Literal["PAYS FOR FAILING", "PAYS FOR LOITERING", "NOTHING FOUND", "CANNOT TELL"]
    strength: Literal["", "ROBUST", "FRAGILE"]
    lines: Annotated[list[Text], FEW]
    alarmed: Whole
    starts: Whole


class NumbersForm(TypedDict):
    """An array: the type of its numbers, its shape, and the numbers row by row."""

    type: Literal["float32", "float64", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32"]
    shape: Annotated[list[Size], Field(min_length=1, max_length=3)]
    numbers: Annotated[list[int | Number], Field(min_length=1, max_length=MOST_NUMBERS)]


def numbers_of(array: NDArray[Any]) -> Data:
    """An array as JSON has it, exactly: its numbers as short as they may be and still be the same in its type."""
    flat = array.ravel()
    numbers = [float(str(number)) for number in flat] if array.dtype == np.float32 else flat.tolist()
    return {"type": array.dtype.name, "shape": list(array.shape), "numbers": numbers}


def array_of(data: Data) -> NDArray[Any]:
    """The array that `numbers_of` told.

    Raises:
        ValueError: Its numbers do not fill its shape, or its type does not hold them.
    """
    if math.prod(data["shape"]) != len(data["numbers"]):
        raise ValueError(f"it has {len(data['numbers'])} numbers for an array of {data['shape']}")
    kind = np.dtype(data["type"])
    if kind.kind in "iu" and not all(isinstance(it, int) for it in data["numbers"]):
        raise ValueError(f"not all numbers of an array of {kind} are whole")
    misfit = f"an array of {kind} does not hold its numbers"
    try:
        with np.errstate(over="ignore"):
            array = np.array(data["numbers"]).astype(kind) if kind.kind == "f" else np.array(data["numbers"], kind)
    except OverflowError:
        raise ValueError(misfit) from None
    if not np.isfinite(array).all():
        raise ValueError(misfit)
    return array.reshape(data["shape"])


Array = Annotated[NDArray[Any], told_as(NumbersForm, array_of)]


class PaidForm(TypedDict):
    """What was paid: in all, and at each step; of each term likewise."""

    total: Number
    discounted: Number
    of_terms: Annotated[dict[Name, Number], FEW]
    steps: Steps
    terms: Annotated[dict[Name, Steps], FEW]


class BehaviourForm(TypedDict):
    """What was done: whether each step was a success, and each measure at each step; null where it is not told."""

    success: Flags
    measures: Annotated[dict[Name, Untold], FEW]
    ended: Literal["terminated", "truncated", "cut"]


class DisturbedForm(TypedDict):
    """See `Disturbed`."""

    noise: Annotated[float, Field(ge=0.0, le=100.0)]
    paid: Number
    success: Share
    episodes: Whole


class FoundForm(TypedDict):
    """How a behaviour was found: what it comes from, and the search, with the steps that it might take and took."""

    made_by: Text
    seed: Whole
    budget: Whole
    steps: Whole
    how: Annotated[list[Text], FEW]


@with_config(OPEN)
class RunsOnForm(TypedDict):
    """Versions, machine, and hashes of sources, as a cell's manifest has them."""

    versions: Annotated[dict[Name, Text], Field(max_length=1_000)]
    machine: dict[Name, Any]
    sources: Annotated[dict[Name, Text], Field(max_length=1_000)]


class TableForm(TypedDict):
    """A policy that is a table: by what is observed, a choice; see `table_policy`."""

    kind: Literal["table"]
    choices: Annotated[dict[Text, int], Field(min_length=1, max_length=100_000)]


class LinearForm(TypedDict):
    """A linear policy; see `act_linear`."""

    kind: Literal["linear policy"]
    weights: Annotated[list[Row], Field(min_length=1, max_length=1_000)]
    mean: Row
    scale: Row


class RandomForm(TypedDict):
    """Random actions."""

    kind: Literal["random"]
    seed: Whole


class RatingForm(TypedDict):
    """A policy in episodes on starts that no search has played: what an answer rests on where chance decides."""

    starts: Annotated[list[Whole], Field(min_length=2, max_length=10_000)]
    paid: Annotated[list[Number], Field(max_length=10_000)]
    success: Annotated[list[Literal[0, 1]], Field(max_length=10_000)]


@with_config(EXACT)  # of all forms within it too
class CertificateForm(TypedDict):
    """The form of the file."""

    format: Literal[1]
    what: Literal["certificate"]
    role: Role
    answer: AnswerForm
    place: Place
    runs_on: RunsOnForm
    found: FoundForm
    start: Whole
    actions: Array
    paid: PaidForm
    behaviour: BehaviourForm
    noise: Annotated[list[DisturbedForm], FEW]
    elsewhere: Annotated[dict[Name, Number], FEW]
    drawn: NotRequired[Annotated[dict[Name, Array], Field(max_length=10)]]
    film: NotRequired[Film]
    policy: NotRequired[TableForm | LinearForm | RandomForm]
    rating: NotRequired[RatingForm]


@dataclass(frozen=True, eq=False)
class Certificate:
    """One behaviour, what it is paid, and all that is needed to play it again.

    Attributes:
        role: Which of the three it is.
        answer: What the search said of the reward, as `AnswerForm`.
        place: What makes its world again.
        runs_on: ``versions``, ``machine`` and ``sources`` when it was written.
        found: How it was found, as `FoundForm`.
        shown: The episode.
        noise: What it was paid while its actions were disturbed, rows as `DisturbedForm`.
        elsewhere: What it is paid in other simulators, by name.
        film: Pictures of it, of one in an environment.
        policy: Who acted, as plain data, where chance decides.
        rating: What that policy comes to on held-out starts, as `RatingForm`; the episode is the first one of these.
    """

    role: Role
    answer: Data
    place: Place
    runs_on: Mapping[str, Data]
    found: Data
    shown: Shown
    noise: Sequence[Data]
    elsewhere: Mapping[str, float]
    film: Film | None = None
    policy: Data | None = None
    rating: Data | None = None

    @property
    def paid(self) -> float:
        """In all."""
        return episode_sum(self.shown.paid)

    @property
    def discounted(self) -> float:
        """The same times gamma^t."""
        return episode_sum(self.shown.paid, self.place.gamma)

    @property
    def outcome(self) -> str:
        """Whether it succeeded, and when."""
        return f"success from step {since(self.shown.success)} on" if self.shown.success[-1] else "no success"

    def to_json(self) -> Data:
        """Plain data; `from_json` gives the same back."""
        shown = self.shown
        told = {
            "format": FORMAT,
            "what": NOUN,
            **{name: to_plain(getattr(self, name)) for name in ("role", "answer", "place", "runs_on", "found")},
            "start": shown.start,
            "actions": numbers_of(shown.actions),
            "paid": {
                "total": self.paid,
                "discounted": self.discounted,
                "of_terms": {name: episode_sum(values) for name, values in shown.terms.items()},
                "terms": to_plain(shown.terms),
                "steps": to_plain(shown.paid),
            },
            "behaviour": {
                "success": shown.success.astype(int).tolist(),
                "measures": {
                    name: [None if math.isnan(value) else value for value in values.tolist()]
                    for name, values in shown.measures.items()
                },
                "ended": shown.ended,
            },
            "noise": to_plain(self.noise),
            "elsewhere": to_plain(self.elsewhere),
            "drawn": {name: numbers_of(it) for name, it in shown.drawn.items()},
            **{name: to_plain(getattr(self, name)) for name in ("film", "policy", "rating")},
        }
        return {name: it for name, it in told.items() if it or name in CertificateForm.__required_keys__}

    @classmethod
    def from_json(cls, data: Data) -> "Certificate":
        """What `to_json` told, also after a way through JSON.

        Raises:
            ValueError: It is something else.
        """
        told: Data = read_form(CertificateForm, data)
        rating, paid = told.get("rating"), told["paid"]
        if ("policy" in told) != ("rating" in told):
            raise ValueError("policy and rating: one of them is missing")
        if rating and len({*map(len, rating.values())}) > 1:
            raise ValueError("rating: it has not a number for each start")
        shown = Shown(
            told["start"],
            told["actions"],
            paid["steps"],
            paid["terms"],
            **told["behaviour"],
            drawn=told.get("drawn", {}),
        )
        if shown.drawn and (set(shown.drawn) != DRAWN or any(it.ndim != 2 for it in shown.drawn.values())):
            raise ValueError(f"drawn: it is not {', '.join(sorted(DRAWN))} in rows")
        rows: Sequence[tuple[str, Any]] = [
            ("actions", shown.actions),
            ("success", shown.success),
            *shown.terms.items(),
            *shown.measures.items(),
            *((name, values[1:]) for name, values in shown.drawn.items()),
        ]
        for name, values in rows:
            if len(values) != len(shown.paid):
                raise ValueError(f"{name}: it has {len(values)} rows for {len(shown.paid)} steps")
        made = cls(shown=shown, **{it.name: told[it.name] for it in fields(cls) if it.name in told})
        # the sums that a file tells are those of its steps, but for rounding
        most = sum(float(np.abs(it).sum()) for it in (shown.paid, *shown.terms.values()))
        sums = [("total", paid["total"], made.paid), ("discounted", paid["discounted"], made.discounted)]
        sums += [(name, it, episode_sum(shown.terms.get(name, np.zeros(1)))) for name, it in paid["of_terms"].items()]
        for name, said, true in sums:
            if abs(said - true) > ROUNDING * most:
                raise ValueError(f"paid, {name}: it is {said}, and its steps come to {true}")
        return made


def rating_text(rating: Data) -> str:
    """What a policy came to on held-out starts, in words."""
    paid = estimate_text(mean_over_seeds(list(rating["paid"])))
    count, share = len(rating["starts"]), np.mean(rating["success"])
    return f"{paid} an episode on {count} held-out starts, success {share:.0%}"


def write_certificate(certificate: Certificate, path: Path) -> None:
    """Write it, whole or not at all.

    Raises:
        OSError: `path` cannot be written.
    """
    write_whole(path, seal(certificate.to_json(), is_flat=True))


def read_certificate(path: Path) -> Certificate:
    """The certificate in a file.

    Raises:
        SchemaError: It is none, is damaged, or a newer version wrote it.
    """
    data = read_sealed(path, NOUN, newest=FORMAT, since=FORMAT, most=MOST_BYTES)
    with reading(path, NOUN):
        return Certificate.from_json(data)


def file_names(certificates: Sequence[Certificate]) -> list[str]:
    """The name of the file of each, all different: those of one reward stand together."""
    labels = list(dict.fromkeys(it.place.reward.label for it in certificates))
    stems = dict(zip(labels, file_stems(labels), strict=True))
    return [f"{stems[it.place.reward.label]}-{it.role}.json" for it in certificates]
