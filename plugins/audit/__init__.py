"""What rewards pay for, and whether they rank behaviour as success does. Trains nothing."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from .audit import audit_table
    from .dataset.audit_dataset import audit_dataset
    from .recorded.recordings import audit_logs, audit_recordings
    from .screen import Cheats
    from .scripts import audit_reward
    from .search.certificate import read_certificate, write_certificate
    from .search.find import find_cheats
    from .search.out import page_in, replay_file, write_found
    from .search.page import cheats_page
    from .transitions.audit_rewards import audit_rewards

__all__ = [
    "Cheats",
    "audit_dataset",
    "audit_logs",
    "audit_recordings",
    "audit_reward",
    "audit_rewards",
    "audit_table",
    "cheats_page",
    "find_cheats",
    "page_in",
    "read_certificate",
    "replay_file",
    "write_certificate",
    "write_found",
]

_HOMES = {
    "audit": "audit_table",
    "dataset.audit_dataset": "audit_dataset",
    "recorded.recordings": "audit_logs audit_recordings",
    "screen": "Cheats",
    "scripts": "audit_reward",
    "search.certificate": "read_certificate write_certificate",
    "search.find": "find_cheats",
    "search.out": "page_in replay_file write_found",
    "search.page": "cheats_page",
    "transitions.audit_rewards": "audit_rewards",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
