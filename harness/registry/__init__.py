"""From a typed name to the object that a plugin registered under it."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.registry.choice import Choice, choose
    from harness.registry.given import Given, read_given
    from harness.registry.parameters import build
    from harness.registry.registry import Registry, load_registry
    from harness.registry.spec import Spec

__all__ = [
    "Choice",
    "Given",
    "Registry",
    "Spec",
    "build",
    "choose",
    "load_registry",
    "read_given",
]

_HOMES = {
    "choice": "Choice choose",
    "given": "Given read_given",
    "parameters": "build",
    "registry": "Registry load_registry",
    "spec": "Spec",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
