"""What rewards pay for, and whether they rank behaviour as success does. Trains nothing."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from .audit import audit_table as audit_table
    from .dataset.audit_dataset import audit_dataset as audit_dataset
    from .recorded.recordings import audit_logs as audit_logs, audit_recordings as audit_recordings
    from .screen import Cheats as Cheats
    from .scripts import audit_reward as audit_reward
    from .search.certificate import read_certificate as read_certificate, write_certificate as write_certificate
    from .search.find import find_cheats as find_cheats
    from .search.out import page_in as page_in, replay_file as replay_file, write_found as write_found
    from .search.page import cheats_page as cheats_page
    from .transitions.audit_rewards import audit_rewards as audit_rewards
else:
    __all__, __getattr__ = face_of(__name__)
