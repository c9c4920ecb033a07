"""The world of one episode: a simulator, a task and a reward as a Gymnasium environment."""

from typing import TYPE_CHECKING

from harness.env.vector_env import ReachVectorEnv as ReachVectorEnv
from harness.face import face_of

if TYPE_CHECKING:
    from harness.env.arm_observation import (
        ArmObservation as ArmObservation,
        kinematics_policy as kinematics_policy,
        why_not_kinematics as why_not_kinematics,
    )
    from harness.env.episodes import Episodes as Episodes
    from harness.env.ideal import IdealSimulation as IdealSimulation, IdealSimulator as IdealSimulator
    from harness.env.solid_probes import require_solids as require_solids
    from harness.env.vector_env import ReachEnv as ReachEnv, World as World, build_world as build_world
else:
    __all__, __getattr__ = face_of(__name__, __file__)
