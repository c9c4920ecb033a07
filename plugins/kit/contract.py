"""What a check is, how it says what is wrong, and how checks are run."""

import copy
import dataclasses
import inspect
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from harness.errors import ContractViolation, one_line
from harness.registry import build, values_of

Level: TypeAlias = Literal["error", "warning"]
"""``error``: the contract is broken. ``warning``: it is kept, but something is slow, or was not tried."""


@dataclass(frozen=True)
class Check:
    """One thing that a plugin has to do, or should do; it is called with what it checks, like the function that it is.

    Attributes:
        name: Of the check, as ``sim-reset``; it stays the same from version to version.
        run: Raises AssertionError, with a sentence, where the plugin does not.
        level: What it means where it does.
    """

    name: str
    run: Callable[..., None]
    level: Level = "error"

    def __call__(self, *subject: Any) -> None:
        """Check `subject`."""
        self.run(*subject)

    @property
    def __name__(self) -> str:
        """Its name once more, as a function has it: pytest calls the test of a check by it."""
        return self.name

    @property
    def fact(self) -> str:
        """What holds where the check is passed: the first paragraph of the function's docstring, on one line."""
        return " ".join(inspect.cleandoc(self.run.__doc__ or "").split("\n\n")[0].split())


def check(name: str, level: Level = "error") -> Callable[[Callable[..., None]], Check]:
    """Make a check of a function: ``@check("sim-reset")``."""
    return lambda run: Check(name, run, level)


def require(condition: object, message: str, *given: object) -> None:
    """Raise AssertionError with `message` unless `condition` holds: a check's way to say no.

    Args:
        condition: What has to hold.
        message: What is wrong if it does not; every ``{}`` in it stands for one of `given`.
        given: Written only where the condition does not hold. Give arrays so, which take long to write.
    """
    if not condition:
        raise AssertionError(message.format(*given) if given else message)


def violations(checks: Iterable[Check], *subject: Any) -> Iterator[ContractViolation]:
    """Run `checks` on `subject` one by one and tell each that fails, or raises anything.

    Args:
        checks: One of the tuples of this package, or some of it.
        subject: What every one of them takes. Each check gets a copy of its own.
    """
    for each in checks:
        try:
            each(*copy.deepcopy(subject))
        except AssertionError as error:
            yield _violation(each, str(error), error)
        except (Exception, SystemExit) as error:  # a plugin may raise anything
            yield _violation(each, f"raised {one_line(error)}", error)


@check("settings-frozen")
def settings_are_frozen(plugin: Any, *_: Any) -> None:
    """The plugin is an instance of a frozen dataclass: what a run was set to cannot change while it runs."""
    require(dataclasses.is_dataclass(plugin), f"{type(plugin).__name__} is no dataclass")
    frozen = getattr(type(plugin), "__dataclass_params__").frozen  # noqa: B009 (mypy does not know the attribute)
    require(frozen, f"{type(plugin).__name__} is not frozen: write @dataclass(frozen=True)")


@check("settings-json")
def settings_survive_json(plugin: Any, *_: Any) -> None:
    """The plugin's fields can be written as JSON and give an equal plugin when read: a cell is kept so."""
    values = values_of(plugin)
    try:
        text = json.dumps(values, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"the settings {values} are no JSON: {error}") from error
    again = values_of(build(type(plugin), json.loads(text), type(plugin).__name__))
    require(again == values, f"the settings {values} come back from JSON as {again}")


def _violation(failed: Check, message: str, cause: BaseException) -> ContractViolation:
    violation = ContractViolation(failed.name, message, failed.level)
    violation.__cause__ = cause
    return violation
