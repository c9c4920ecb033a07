"""How far simulators differ that are told the same."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from .contenders import Missing, choose_contenders
    from .orders import Setting
    from .page import parity_table, write_parity
    from .parity import compare_simulators

__all__ = [
    "Missing",
    "Setting",
    "choose_contenders",
    "compare_simulators",
    "parity_table",
    "write_parity",
]

_HOMES = {
    "contenders": "Missing choose_contenders",
    "orders": "Setting",
    "page": "parity_table write_parity",
    "parity": "compare_simulators",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
