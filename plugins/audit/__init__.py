"""What rewards pay for, and whether they rank behaviour as success does. Trains nothing."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .dataset.audit_dataset import audit_dataset
    from .search.find import find_cheats
    from .transitions.audit_rewards import audit_rewards

__all__ = ["audit_dataset", "audit_rewards", "find_cheats"]

_HOMES = {
    "audit_dataset": ".dataset.audit_dataset",
    "audit_rewards": ".transitions.audit_rewards",
    "find_cheats": ".search.find",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOMES[name], __name__), name)
