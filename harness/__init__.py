"""Tells whether a reward function makes a robot behave better, or only makes the numbers bigger."""

from typing import TYPE_CHECKING, Any

import wrapt

from harness.face import face_of, know_earlier_modules
from harness.hookspecs import Register as Register, hookimpl as hookimpl

if TYPE_CHECKING:
    from harness.arrays import Float as Float, Float32 as Float32, Ints as Ints, Mask as Mask
    from harness.env.vector_env import make_env as make_env
    from harness.experiment.experiment import run as run
    from harness.recorder.evaluate_policy import evaluate_policy as evaluate_policy
    from harness.recorder.record_rewards import RecordRewards as RecordRewards
    from harness.recorder.record_vector_rewards import RecordVectorRewards as RecordVectorRewards
    from harness.registry.registry import load_registry as load_registry
    from harness.results.load import load_results as load_results
    from harness.robot.robot import load_robot as load_robot
else:
    __all__, __getattr__ = face_of(__name__)

__version__ = "0.4.0"


def _register_envs(gymnasium: Any) -> None:
    """Make `gymnasium.make("harness/Reach-v0")` work, whichever of the two is imported first; ReachGoal-v0 too."""
    gymnasium.register(
        "harness/Reach-v0",
        entry_point="harness.env.vector_env:ReachEnv",
        vector_entry_point="harness.env.vector_env:make_env",
    )
    gymnasium.register("harness/ReachGoal-v0", entry_point="harness.env.goal_env:ReachGoalEnv")


know_earlier_modules()
wrapt.when_imported("gymnasium")(_register_envs)
