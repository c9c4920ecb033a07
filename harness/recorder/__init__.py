"""Records what several rewards pay for the steps of any Gymnasium environment, while a learner trains in it."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.recorder.recorder import GivenUp, Noted
    from harness.recorder.retake import Later, Retake

__all__ = ["GivenUp", "Later", "Noted", "Retake"]

_HOMES = {"recorder": "GivenUp Noted", "retake": "Later Retake"}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
