"""Tells whether a reward function makes a robot behave better, or only makes the numbers bigger."""

import importlib
from typing import TYPE_CHECKING, Any

import wrapt

from harness.hookspecs import Register, hookimpl

if TYPE_CHECKING:
    from harness.env.make import make_env
    from harness.experiment.experiment import run
    from harness.recorder.evaluate_policy import evaluate_policy
    from harness.recorder.record_rewards import RecordRewards
    from harness.recorder.record_vector_rewards import RecordVectorRewards
    from harness.results import load_results
    from harness.robot.robot import load_robot

__version__ = "0.3.0"
__all__ = [
    "RecordRewards",
    "RecordVectorRewards",
    "Register",
    "__version__",
    "evaluate_policy",
    "hookimpl",
    "load_results",
    "load_robot",
    "make_env",
    "run",
]

# Looked up when first used: `import harness` has to stay light, for `harness --help` and for every plugin.
_HOMES = {
    "RecordRewards": "harness.recorder.record_rewards",
    "RecordVectorRewards": "harness.recorder.record_vector_rewards",
    "evaluate_policy": "harness.recorder.evaluate_policy",
    "load_results": "harness.results.load",
    "load_robot": "harness.robot.robot",
    "make_env": "harness.env.make",
    "run": "harness.experiment.experiment",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'harness' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOMES[name]), name)


def _register_envs(gymnasium: Any) -> None:
    """Make `gymnasium.make("harness/Reach-v0")` work, whichever of the two is imported first; ReachGoal-v0 too."""
    gymnasium.register(
        "harness/Reach-v0",
        entry_point="harness.env.make:ReachEnv",
        vector_entry_point="harness.env.make:make_env",
    )
    gymnasium.register("harness/ReachGoal-v0", entry_point="harness.env.goal_env:ReachGoalEnv")


wrapt.when_imported("gymnasium")(_register_envs)
