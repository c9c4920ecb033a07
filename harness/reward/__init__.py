"""What an author of rewards imports; see `harness.reward.reward` for the interface."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.reward.given import Given as Given
from harness.reward.reward import Array as Array, Carry as Carry, Pay as Pay, Reward as Reward
from harness.reward.steps import Sample as Sample, Steps as Steps
from harness.reward.terms import Paid as Paid, pay as pay

if TYPE_CHECKING:
    from harness.authoring.observed_reward import ObservedReward as ObservedReward
    from harness.authoring.wrapped_reward import WrappedReward as WrappedReward
else:
    __all__, __getattr__ = face_of(__name__)
