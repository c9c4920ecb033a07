"""What the JSON of an experiment's folder has to look like: names, types, ranges. It is checked before it is used.

A folder may come from anybody. A file of another form is damaged; no value of a wrong type gets further than here.
"""

from datetime import datetime
from itertools import pairwise
from typing import Annotated, Any, Literal, NotRequired

import tomli_w
from pydantic import AfterValidator, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError, with_config
from typing_extensions import TypedDict

from harness.files.names import is_inside, twins
from harness.registry.toml_file import MOST_DEPTH, depth_of

MOST_CELLS = 100_000
"""The most cells of a plan. All are in memory, and each leaves a folder."""
MOST_SEEDS = 10_000
"""The most seeds. With more, intervals hardly get narrower, and the trainings in sequence would take a year."""
MOST_LOOKS = 1_000
"""The most looks of a plan."""
MOST_FILES = 100_000
"""The most files of a cell's folder."""


def _inside(path: str) -> str:
    if not is_inside(path):
        raise ValueError("is no path of a file in the folder")
    return path


def _increasing(looks: list[int]) -> list[int]:
    if any(b <= a for a, b in pairwise(looks)):
        raise ValueError("does not increase")
    return looks


def _writable(experiment: dict[str, Any]) -> dict[str, Any]:
    if depth_of(experiment) > MOST_DEPTH:
        raise ValueError(f"is nested more than {MOST_DEPTH} deep")
    try:
        tomli_w.dumps(experiment).encode()
    except (TypeError, ValueError):  # null, or half a character
        raise ValueError("holds a value that no experiment file has") from None
    return experiment


def _distinct(files: dict[str, str]) -> dict[str, str]:
    if alike := twins(files):
        raise ValueError(f"{alike[0]} is named twice, in other letters")
    return files


def _moment(text: str) -> str:
    if text and datetime.fromisoformat(text).tzinfo is None:
        raise ValueError("has no time zone")
    return text


Name = Annotated[str, StringConstraints(min_length=1, max_length=1_000)]
Line = Annotated[str, StringConstraints(max_length=100_000)]
Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
FilePath = Annotated[str, StringConstraints(max_length=1_000), AfterValidator(_inside)]
"""In the folder that names it, or below."""
Count = Annotated[int, Field(gt=0, lt=2**53)]
Whole = Annotated[int, Field(ge=0, lt=2**63)]
LONGEST = 1e10
"""The most seconds that work may have taken, [s]: 300 years."""
Seconds = Annotated[float, Field(ge=0, le=LONGEST, allow_inf_nan=False)]
Moment = Annotated[str, StringConstraints(max_length=100), AfterValidator(_moment)]
"""ISO 8601 with a time zone; empty where nothing was begun."""
Plain = Annotated[str, StringConstraints(max_length=10_000)] | bool | int | Annotated[float, Field(allow_inf_nan=False)]
Listed = Plain | None | Annotated[list[Plain | None], Field(max_length=10_000)]
Value = Listed | Annotated[list[Listed], Field(max_length=10_000)]
"""The value of a parameter."""
Status = Literal["done", "failed", "skipped", "pending", "damaged", "not needed"]

EXACT = ConfigDict(strict=True, extra="forbid")
OPEN = ConfigDict(strict=True, extra="allow")


@with_config(EXACT)
class ChoiceForm(TypedDict):
    """See `harness.registry.choice.Choice`."""

    name: Name
    label: Name
    params: dict[Name, Value]


@with_config(EXACT)
class CellForm(TypedDict):
    """See `harness.record.cell.Cell`."""

    simulator: ChoiceForm
    robot: Name
    task: ChoiceForm
    algorithm: ChoiceForm
    reward: ChoiceForm
    seed: Whole
    steps: Count
    evaluation_episodes: Count
    evaluate_every: NotRequired[Whole]
    deterministic: NotRequired[bool]
    evaluation_horizon: NotRequired[Count]
    records: NotRequired[Annotated[list[Literal["qvel"]], Field(max_length=1)]]


@with_config(OPEN)
class MachineForm(TypedDict, total=False):
    """See `harness.experiment.provenance.describe_machine`."""

    system: Line
    cpu: Line
    cpu_flags: list[Name]
    cores: int | None


@with_config(OPEN)
class EnvironmentForm(TypedDict, total=False):
    """See `harness.experiment.provenance.describe_environment`."""

    versions: dict[Name, Line]
    machine: MachineForm
    engine: Line | None
    commit: Line
    command: Line
    sources: dict[Name, Line]


@with_config(EXACT)
class EndingForm(TypedDict):
    """See `harness.record.manifest.Ending`."""

    format: Literal[1, 2]
    status: Status
    reason: Line
    started: Moment
    seconds: Seconds
    environment: EnvironmentForm
    files: Annotated[dict[FilePath, Digest], Field(max_length=MOST_FILES), AfterValidator(_distinct)]


@with_config(EXACT)
class ManifestForm(EndingForm):
    """See `harness.record.manifest.Manifest`."""

    id: Name
    cell: CellForm
    training_seconds: Seconds
    resumed_from: NotRequired[Whole]
    note: NotRequired[Line]
    peak_memory: NotRequired[Whole]
    error: NotRequired[Line]
    unit: NotRequired[Line]


@with_config(OPEN)
class TermsForm(TypedDict, total=False):
    """See `harness.record.terms.Terms`."""

    looks: Annotated[
        list[Annotated[int, Field(gt=0, le=MOST_SEEDS)]], Field(max_length=MOST_LOOKS), AfterValidator(_increasing)
    ]
    asked: Count
    margin: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    race: bool
    averaged: Count
    grown: Annotated[list[Whole], Field(max_length=MOST_LOOKS)]
    joined: Annotated[list[Name], Field(max_length=MOST_CELLS)]


@with_config(EXACT)
class PlanForm(TypedDict):
    """See `harness.record.plan_file.StoredPlan`."""

    format: NotRequired[Literal[1, 2]]
    baseline: Name
    a_a: bool
    control: NotRequired[list[Annotated[list[Whole], Field(min_length=2, max_length=2)]]]
    cells: Annotated[list[CellForm], Field(max_length=MOST_CELLS)]
    experiment: NotRequired[Annotated[dict[Name, Any], AfterValidator(_writable)]]
    experiment_digest: NotRequired[Digest]
    terms: NotRequired[TermsForm]


MANIFEST: TypeAdapter[ManifestForm] = TypeAdapter(ManifestForm)
PLAN: TypeAdapter[PlanForm] = TypeAdapter(PlanForm)


def require_form(form: TypeAdapter[Any], data: Any) -> None:
    """See whether parsed JSON has a form.

    Raises:
        ValueError: It has not; the message names the first key that is wrong.
    """
    try:
        form.validate_python(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise ValueError(f"{where}: {first['msg']}") from None
