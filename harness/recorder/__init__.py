"""Records what several rewards pay for the steps of any Gymnasium environment, while a learner trains in it."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.recorder.env_facts import Columns as Columns
    from harness.recorder.recorder import GivenUp as GivenUp, Noted as Noted
    from harness.recorder.retake import Retake as Retake
else:
    __all__, __getattr__ = face_of(__name__, __file__)
