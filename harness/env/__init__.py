"""The world of one episode: a simulator, a task and a reward as a Gymnasium environment."""

from typing import TYPE_CHECKING, Any

from harness.env.vector_env import ReachVectorEnv
from harness.face import look_up

if TYPE_CHECKING:
    from harness.env.arm_observation import ArmObservation, kinematics_policy, why_not_kinematics
    from harness.env.episodes import Episodes
    from harness.env.ideal import IdealSimulation, IdealSimulator
    from harness.env.make import ReachEnv, World, build_world
    from harness.env.solid_probes import require_solids

__all__ = [
    "ArmObservation",
    "Episodes",
    "IdealSimulation",
    "IdealSimulator",
    "ReachEnv",
    "ReachVectorEnv",
    "World",
    "build_world",
    "kinematics_policy",
    "require_solids",
    "why_not_kinematics",
]

_HOMES = {
    "arm_observation": "ArmObservation kinematics_policy why_not_kinematics",
    "episodes": "Episodes",
    "ideal": "IdealSimulation IdealSimulator",
    "make": "ReachEnv World build_world",
    "solid_probes": "require_solids",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
