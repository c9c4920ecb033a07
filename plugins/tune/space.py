"""The values that a search may choose from: ``learning_rate=1e-4..1e-2:log``, ``batch_size=64|128``."""

import math
import re
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import pydantic

from harness.authoring.commands import did_you_mean, parameters_of
from harness.errors import HarnessError, UsageError, sentence

DEFAULTS = {"learning_rate": "1e-4..1e-2:log", "gamma": "0.9..0.999"}
"""The parameters that are searched by default, if an algorithm has them."""

_RANGE = re.compile(r"(?P<low>[^|]+?)\.\.(?P<high>[^|:][^|]*?)(?P<log>:log)?")


@dataclass(frozen=True)
class Range:
    """A parameter between two numbers, both included.

    Attributes:
        name: Of the parameter.
        low: The least value.
        high: The greatest, above `low`.
        whole: Whether the values are whole numbers.
        log: Whether each factor of ten is as likely as the next.
    """

    name: str
    low: float
    high: float
    whole: bool
    log: bool

    @property
    def text(self) -> str:
        """The text as `parse_space` reads it."""
        return f"{self.low!r}..{self.high!r}{':log' if self.log else ''}"

    def value(self, drawn: Any) -> Any:
        """The value that the algorithm gets for a drawn one. It has six digits, like the label."""
        return int(drawn) if self.whole else min(max(float(f"{drawn:g}"), self.low), self.high)

    def locate(self, value: Any) -> Any:
        """The value, if it lies in the range; else None."""
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return value if is_number and self.low <= value <= self.high else None


@dataclass(frozen=True)
class Options:
    """A parameter that is one of several.

    Attributes:
        name: Of the parameter.
        texts: The options as they are written, ``64x64``; no two mean the same.
        values: What they mean.
    """

    name: str
    texts: tuple[str, ...]
    values: tuple[Any, ...]

    @property
    def text(self) -> list[str]:
        """The text as `parse_space` reads it."""
        return list(self.texts)

    def value(self, drawn: Any) -> Any:
        """The value that the algorithm gets for a drawn text."""
        return self.values[self.texts.index(drawn)]

    def locate(self, value: Any) -> Any:
        """The text of the option that means `value`; None if none does."""
        return self.texts[self.values.index(value)] if value in self.values else None


Dimension: TypeAlias = Range | Options


def parse_space(search: Mapping[str, Any], target: Any, noun: str) -> tuple[Dimension, ...]:
    """The dimensions of a search over the parameters of the dataclass `target`.

    Args:
        search: By parameter a text, or a list of options; if empty, those of `DEFAULTS` that the target has.
        target: What an algorithm's name stands for.
        noun: What to call it, ``algorithm 'sac'``.

    Raises:
        UsageError: A parameter is not known, a text is malformed, or what it allows the parameter does not.
    """
    names = [parameter.name for parameter in parameters_of(target)]
    there = f"There is: {', '.join(names) or 'none'}."
    search = search or {name: text for name, text in DEFAULTS.items() if name in names}
    if not search:
        raise UsageError(f"{sentence(noun)} has neither {' nor '.join(DEFAULTS)}: say what to search. {there}")
    for name in search:
        if name not in names:
            raise UsageError(f"{sentence(noun)} has no parameter '{name}'. {there}{did_you_mean(name, names)}")
    return tuple(_Field(target, name).dimension(given) for name, given in search.items())


class _Field:
    """A parameter of a dataclass: the types and values that it allows."""

    def __init__(self, target: Any, name: str) -> None:
        self._adapter = pydantic.TypeAdapter(target)
        self._name = name
        self._types = set(_parts(typing.get_type_hints(target)[name]))

    def dimension(self, given: Any) -> Dimension:
        texts = [_text(item) for item in given] if isinstance(given, list) else given.split("|")
        if len(texts) != 1 or isinstance(given, list):
            return self._options([text.strip() for text in texts])
        match = _RANGE.fullmatch(texts[0].strip())
        if not match:
            raise UsageError(why_no_range(self._name, given))
        return self._range(str(given), match["low"], match["high"], bool(match["log"]))

    def _options(self, texts: list[str]) -> Options:
        if not all(texts) or not texts:
            what = "one of its options is empty" if texts else "it has no option"
            raise UsageError(f"search '{self._name}={'|'.join(texts)}': {what}: {syntax_of(self._name)}")
        values = [self._convert(text) for text in texts]
        for index, value in enumerate(values):
            if value in values[:index]:
                raise UsageError(f"search '{self._name}={'|'.join(texts)}': '{texts[index]}' is given twice")
        return Options(self._name, tuple(texts), tuple(values))

    def _range(self, text: str, low: str, high: str, log: bool) -> Range:
        whole = int in self._types and float not in self._types
        if not self._types & {int, float}:
            raise UsageError(f"search '{self._name}={text}': {self._name} is no number: write options, A|B|C")
        ends = [self._number(text, end, whole) for end in (low, high)]
        if not ends[0] < ends[1]:
            raise UsageError(f"search '{self._name}={text}': the range ends before it begins")
        if log and ends[0] <= 0:
            raise UsageError(f"search '{self._name}={text}': a range with :log has to begin above 0")
        for end in ends:
            self._convert(end)
        return Range(self._name, ends[0], ends[1], whole, log)

    def _number(self, text: str, end: str, whole: bool) -> float:
        kind = "a whole number" if whole else "a number"
        try:
            number = int(end) if whole else float(end)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise UsageError(f"search '{self._name}={text}': '{end}' is not {kind}: {syntax_of(self._name)}")
        return number

    def _convert(self, given: Any) -> Any:
        """The value as the field's type. Whether it fits other parameters is checked when a trial is built.

        Raises:
            UsageError: The field does not allow it.
        """
        splits = any(typing.get_origin(part) is tuple for part in self._types)
        value = given.split("x") if splits and isinstance(given, str) else given
        try:
            return getattr(self._adapter.validate_python({self._name: value}), self._name)
        except pydantic.ValidationError as error:
            own = [problem for problem in error.errors() if problem["loc"][:1] == (self._name,)]
            if own:
                deepest = max(own, key=lambda problem: len(problem["loc"]))
                raise UsageError(f"search: {self._name}={given}: {deepest['msg']}") from None
            return given
        except HarnessError:
            return given


def why_no_range(name: str, given: Any) -> str:
    """What is missing in a text, or another value, that is neither a range nor several options."""
    low, dots, high = str(given).partition("..")
    if dots:
        missing = [end for end, text in (("lower", low), ("upper", high.removesuffix(":log"))) if not text.strip()]
        what = f"the range has no {' and no '.join(missing)} end"
    elif str(given).strip():
        what = f"one value is no search (--algo NAME:{name}={given} sets it)"
    else:
        what = "it has no values"
    return f"search '{name}={given}': {what}: {syntax_of(name)}"


def syntax_of(name: str) -> str:
    """What may be written for a parameter."""
    return f"write {name}=LOW..HIGH, {name}=LOW..HIGH:log or {name}=A|B|C"


def _parts(hint: Any) -> Iterator[Any]:
    """The hint, and if it is a union or a literal the parts of it."""
    yield hint
    if typing.get_origin(hint) is not tuple:
        for part in typing.get_args(hint):
            yield from _parts(part)


def _text(item: Any) -> str:
    """An option as the command line would write it."""
    if isinstance(item, list):
        return "x".join(_text(part) for part in item)
    return str(item).lower() if isinstance(item, bool) else str(item)
