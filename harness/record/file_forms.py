"""What the JSON of an experiment's folder has to look like: names, types, ranges. It is checked before it is used.

A folder may come from anybody. A file of another form is damaged; no value of a wrong type gets further than here.
"""

import json
from collections.abc import Callable, Mapping
from datetime import datetime
from functools import cache
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    GetPydanticSchema,
    StringConstraints,
    TypeAdapter,
    ValidationError,
    with_config,
)
from pydantic_core.core_schema import no_info_after_validator_function
from typing_extensions import TypedDict

from harness.files.bounded import is_inside, twins
from harness.registry.choice import Choice

T = TypeVar("T")
_adapter: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)

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


def _distinct(files: Mapping[str, str]) -> Mapping[str, str]:
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
Number = Annotated[float, Field(allow_inf_nan=False)]
LONGEST = 1e10
"""The most seconds that work may have taken, [s]: 300 years."""
Seconds = Annotated[float, Field(ge=0, le=LONGEST, allow_inf_nan=False)]
Moment = Annotated[str, StringConstraints(max_length=100), AfterValidator(_moment)]
"""ISO 8601 with a time zone; empty where nothing was begun."""
Plain = Annotated[str, StringConstraints(max_length=10_000)] | bool | int | Number
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


def told_as(form: Any, make: Callable[[Any], Any]) -> GetPydanticSchema:
    """Annotates a field that JSON tells in another form; `make` gets that, and returns what the field holds."""
    return GetPydanticSchema(
        lambda _, schema_of: no_info_after_validator_function(make, schema_of.generate_schema(form))
    )


Chosen = Annotated[Choice, told_as(ChoiceForm, Choice.from_json)]


@with_config(OPEN)
class MachineForm(TypedDict, total=False):
    """See `harness.experiment.provenance.describe_machine`."""

    system: Line
    cpu: Line
    cpu_flags: list[Name]
    kernel: Line
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


Environment = Annotated[Mapping[str, Any], told_as(EnvironmentForm, dict)]
Digests = Annotated[Mapping[FilePath, Digest], Field(max_length=MOST_FILES), AfterValidator(_distinct)]


def read_form(kind: type[T], data: Any) -> T:
    """What parsed JSON tells, as a value of a type whose annotations say what may stand in each field.

    Raises:
        ValueError: It has another form; the message names the first key that is wrong.
    """
    try:
        told: T = _adapter(kind).validate_json(json.dumps(data))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise ValueError(f"{where}: {first['msg']}") from None
    return told
