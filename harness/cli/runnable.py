"""What can be run with what is installed here."""

from collections.abc import Sequence

from harness.registry.choice import Registry
from harness.text import command_text

FAVOURITES = {"simulators": ("mujoco", "kinematic"), "algorithms": ("sac", "ik")}
"""What an example names, the first of them that is installed; else whatever is."""


def usable(registry: Registry, kind: str) -> list[str]:
    """Names of one kind that lack no library."""
    return [name for name in registry.typed_names(kind) if not registry.get(kind, name).missing]


def example_run(registry: Registry) -> str:
    """A command that runs here; empty where there is no simulator, or no algorithm."""
    sim, algo = (_favourite(usable(registry, kind), wanted) for kind, wanted in FAVOURITES.items())
    return command_text("harness", "run", "--sim", sim, "--algo", algo) if sim and algo else ""


def _favourite(names: Sequence[str], wanted: Sequence[str]) -> str:
    return next((name for name in (*wanted, *names) if name in names), "")
