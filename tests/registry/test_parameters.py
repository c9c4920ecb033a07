"""Typed parameters: the fields of a dataclass, converted and checked."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

import pydantic.dataclasses
import pytest
from pydantic import Field

from harness.errors import PluginError, UsageError
from harness.registry import Registry, build, parameters_of, values_of
from harness.registry.members import Parameter, resolved


@dataclass(frozen=True)
class Thing:
    count: Annotated[int, Field(gt=0, description="how many")] = 3
    rate: Annotated[float, Field(ge=0, le=1)] = 0.5
    layers: tuple[Annotated[int, Field(gt=0)], ...] = (64, 64)
    point: tuple[float, float, float] = (0.0, 0.0, 1.0)
    mode: Literal["fast", "slow"] = "fast"
    loud: bool = False
    names: list[str] = field(default_factory=lambda: ["a"])
    kind: ClassVar[str] = "thing"
    cache: int = field(default=0, init=False)


@dataclass(frozen=True)
class Needy:
    weight: float


@dataclass(frozen=True)
class Picky:
    low: float = 0.0
    high: float = 1.0

    def __post_init__(self):
        if self.low >= self.high:
            raise ValueError("low must be below high")


@dataclass(frozen=True)
class Rough:
    rate: float = 1
    sizes: tuple[int, ...] = (3,)


@dataclass(frozen=True)
class Wrong:
    count: Annotated[int, Field(gt=0)] = 0


@pydantic.dataclasses.dataclass
class Curious:
    @pydantic.model_validator(mode="after")
    def _look(self, info):
        self.seen = info.context["registry"]
        return self


class Plain:
    """No dataclass."""


@dataclass(frozen=True)
class Opaque:
    plain: Plain = field(default_factory=Plain)


@dataclass(frozen=True)
class Misspelt:
    rate: "flaot" = 0.5  # noqa: F821 (that is the point)


def test_texts_are_converted_to_the_type_of_their_field(subtests):
    """What a command line gives as text and a file as a number comes out the same."""
    rows = [
        ("count", "7", 7),
        ("rate", "0.25", 0.25),
        ("rate", 1, 1.0),
        ("layers", "32", (32,)),
        ("layers", "32x16", (32, 16)),
        ("layers", [32, 16], (32, 16)),
        ("point", "0.5x-1x1e-2", (0.5, -1.0, 0.01)),
        ("mode", "slow", "slow"),
        ("loud", "true", True),
        ("loud", "no", False),
    ]
    for key, given, value in rows:
        with subtests.test(key=key, given=given, value=value):
            built = build(Thing, {key: given}, "thing 'x'")
            assert getattr(built, key) == value
            assert type(getattr(built, key)) is type(value)


def test_what_does_not_fit_is_refused_in_one_line(subtests):
    """The message names the parameter, what was given, and what is allowed."""
    rows = [
        ("count", "0", "Thing 'x': count='0': Input should be greater than 0"),
        ("count", "1.5", "Thing 'x': count='1.5': Input should be a valid integer"),
        ("rate", "2", "Thing 'x': rate='2': Input should be less than or equal to 1"),
        ("rate", "nan", "Thing 'x': rate='nan': Input should be"),
        ("point", "0x0xnan", "Thing 'x': point=(0.0, 0.0, nan): Input should be a finite number"),
        ("layers", "32x0", "Thing 'x': layers.1='0': Input should be greater than 0"),
        ("layers", "axb", "Thing 'x': layers.0='a': Input should be a valid integer"),
        ("point", "1x2", "Thing 'x': point.2 has to be given"),
        ("point", "1x2x3x4", "Thing 'x': point=['1', '2', '3', '4']: Tuple should have at most 3 items"),
        ("mode", "medium", "Thing 'x': mode='medium': Input should be 'fast' or 'slow'"),
        ("cuont", "1", "Thing 'x' has no parameter 'cuont'. There is: count, rate, layers, point, mode, loud, names. "),
        ("kind", "1", "Thing 'x' has no parameter 'kind'."),
        ("cache", "1", "Thing 'x' has no parameter 'cache'."),
    ]
    for key, given, message in rows:
        with subtests.test(key=key, given=given, message=message):
            with pytest.raises(UsageError) as error:
                build(Thing, {key: given}, "thing 'x'")
            assert str(error.value).startswith(message)
            assert "\n" not in str(error.value)


def test_unknown_parameter_offers_the_nearest():
    """A slip of the finger is named."""
    with pytest.raises(UsageError, match=r"Did you mean 'count'\?$"):
        build(Thing, {"cuont": 1}, "thing")


def test_paths_keep_their_capitals():
    """The noun starts the sentence in upper case, and is left alone otherwise."""
    with pytest.raises(UsageError, match=r"^Experiment file '/Home/Me.toml' has no parameter"):
        build(Thing, {"x": 1}, "experiment file '/Home/Me.toml'")


def test_missing_parameter_is_named():
    """A field without a default has to be given."""
    with pytest.raises(UsageError, match=r"^Thing: weight has to be given$"):
        build(Needy, {}, "thing")


def test_parameters_are_checked_against_one_another():
    """What the dataclass itself refuses is a usage error with its words."""
    with pytest.raises(UsageError, match="low must be below high"):
        build(Picky, {"low": "2"}, "thing")


@pytest.mark.parametrize("target", [Plain, Plain(), Opaque, Misspelt], ids=["class", "object", "field", "annotation"])
def test_target_whose_parameters_cannot_be_checked_is_a_broken_plugin(target):
    """A target that is no dataclass, or whose types say nothing, is the plugin's fault and not the user's."""
    with pytest.raises(PluginError, match=r"^Thing 'x'") as error:
        build(target, {}, "thing 'x'")
    assert "\n" not in str(error.value)


def test_resolved_tells_what_differs():
    """All parameters with their values, and apart those that are not at their default."""
    values, changed = resolved(Thing, build(Thing, {"count": "3", "rate": "0.25"}, "thing"), "thing")
    assert list(values) == ["count", "rate", "layers", "point", "mode", "loud", "names"]
    assert changed == {"rate": 0.25}


def test_resolved_default_has_the_type_of_its_field():
    """Also where its author wrote another; what is built has it as it was written."""
    built = build(Rough, {}, "thing")
    values, changed = resolved(Rough, built, "thing")
    assert (type(built.rate), type(values["rate"]), values, changed) == (int, float, {"rate": 1.0, "sizes": (3,)}, {})


def test_default_that_does_not_fit_its_field_is_refused():
    """With the words for a value that a user gives."""
    with pytest.raises(UsageError, match="Thing 'x': count=0: Input should be greater than 0"):
        resolved(Wrong, build(Wrong, {}, "thing 'x'"), "thing 'x'")


def test_registry_is_handed_to_validators():
    """A target that builds on a registered one finds it in the context; who hands none in has none."""
    registry = Registry()
    assert build(Curious, {}, "thing", registry).seen is registry
    assert build(Curious, {}, "thing").seen is None


def test_values_of_a_built_thing():
    """The parameters of an instance are those it was built with."""
    assert values_of(Picky(low=0.5)) == {"low": 0.5, "high": 1.0}


def test_parameters_of_a_dataclass():
    """Name, type, default and description, in the order of the fields; what is no parameter is left out."""
    parameters = parameters_of(Thing)
    assert parameters[0] == Parameter("count", "int", 3, "how many")
    assert [parameter.default for parameter in parameters] == [3, 0.5, (64, 64), (0.0, 0.0, 1.0), "fast", False, ["a"]]
    assert parameters[2].type == "tuple[int, ...]"


def test_other_targets_take_no_parameters():
    """A folder, say, has none."""
    assert parameters_of(Plain()) == []
