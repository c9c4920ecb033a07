"""How checks say what is wrong, and how they are run."""

import copy
import dataclasses
import json
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from harness.errors import ContractViolation, one_line
from harness.registry.parameters import build, values_of


def require(condition: object, message: str) -> None:
    """Raise AssertionError with `message` unless `condition` holds: a check's way to say no."""
    if not condition:
        raise AssertionError(message)


def violations(checks: Iterable[Callable[..., None]], *subject: Any) -> Iterator[ContractViolation]:
    """Run `checks` on `subject` one by one and tell each that fails, or raises anything.

    Args:
        checks: One of the tuples of this package, or some of it.
        subject: What every one of them takes. Each check gets a copy of its own.
    """
    for check in checks:
        try:
            check(*copy.deepcopy(subject))
        except AssertionError as error:
            yield _violation(check, str(error), error)
        except Exception as error:  # a plugin may raise anything
            yield _violation(check, f"raised {one_line(error)}", error)


def raise_first(checks: Iterable[Callable[..., None]], *subject: Any) -> None:
    """Raise the first of the `violations`; the checks after it are not run."""
    for violation in violations(checks, *subject):
        raise violation


def settings_are_frozen(plugin: Any, *_: Any) -> None:
    """The plugin is an instance of a frozen dataclass: what a run was set to cannot change while it runs."""
    require(dataclasses.is_dataclass(plugin), f"{type(plugin).__name__} is no dataclass")
    frozen = getattr(type(plugin), "__dataclass_params__").frozen  # noqa: B009 (mypy does not know the attribute)
    require(frozen, f"{type(plugin).__name__} is not frozen: write @dataclass(frozen=True)")


def settings_survive_json(plugin: Any, *_: Any) -> None:
    """The plugin's fields can be written as JSON and give an equal plugin when read: a cell is kept so."""
    values = values_of(plugin)
    try:
        text = json.dumps(values, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"the settings {values} are no JSON: {error}") from error
    again = values_of(build(type(plugin), json.loads(text), type(plugin).__name__))
    require(again == values, f"the settings {values} come back from JSON as {again}")


def _violation(check: Callable[..., None], message: str, cause: Exception) -> ContractViolation:
    violation = ContractViolation(check.__name__, message)
    violation.__cause__ = cause
    return violation
