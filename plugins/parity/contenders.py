"""Which simulators are compared."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from harness.errors import PluginError, UsageError
from harness.registry import Choice, Registry, choose, split_list
from harness.simulator import Simulator

from .performance import Failure

USUAL = "mujoco"
"""The reference, where it is compared."""


class Missing(NamedTuple):
    """A simulator whose library is not installed."""

    name: str
    extra: str | None
    """The extra of its distribution that brings the library."""
    remedy: str
    """What to type."""


@dataclass(frozen=True)
class Contenders:
    """Simulators by name, the reference first.

    Attributes:
        simulators: Each ready to be opened, or why it cannot be.
        missing: Those that were not named and are not installed.
    """

    simulators: dict[str, Simulator | Failure]
    missing: tuple[Missing, ...] = ()

    @property
    def reference(self) -> str:
        """What the others are compared with, in the first place."""
        return next(iter(self.simulators))


def choose_contenders(registry: Registry, given: Sequence[str], reference: str | None) -> Contenders:
    """The simulators that a user named, or else every one that is installed.

    Args:
        registry: The plugins.
        given: ``mujoco,pybullet:substeps=40``, one or several; none for all.
        reference: Its name; taken in if it is not among the others. `USUAL`, or else the first, if None.

    Raises:
        UsageError: A name or a parameter is not known, a named simulator is not installed, a name is given twice, or
            there is none.
    """
    installed = [name for name in registry.names("simulators") if not _missing(registry, name)]
    names = split_list(given) or installed
    found = _choose(registry, names, named=bool(given))
    if reference is None:
        first = USUAL if USUAL in found else next(iter(found), "")
    else:
        chosen = _choose(registry, [reference], named=True)
        first = next(iter(chosen))
        found = chosen | found
    if not found:
        raise UsageError("No simulator is installed: 'harness describe simulators' says what brings one")
    ordered = {first: found[first], **found}
    built = {
        name: choice if isinstance(choice, Failure) else choice.build(registry, "simulators")
        for name, choice in ordered.items()
    }
    return Contenders(built, () if given else _all_missing(registry))


def _choose(registry: Registry, names: Sequence[str], named: bool) -> dict[str, Choice | Failure]:
    """The choices by label. What nobody named may be broken: the others go on."""
    found: dict[str, Choice | Failure] = {}
    for name in names:
        try:
            choice = choose(registry, "simulators", name)
        except PluginError as error:
            if named:
                raise
            found[name] = Failure(str(error))
            continue
        if choice.label in found:
            raise UsageError(f"--sim names '{choice.label}' twice: give each simulator once, or other parameters")
        found[choice.label] = choice
    return found


def _missing(registry: Registry, name: str) -> bool:
    """Whether the library is."""
    return bool(registry.get("simulators", name).missing)


def _all_missing(registry: Registry) -> tuple[Missing, ...]:
    names = [name for name in registry.names("simulators") if _missing(registry, name)]
    specs = [registry.get("simulators", name) for name in names]
    return tuple(Missing(spec.name, spec.extra, spec.remedy) for spec in specs)
