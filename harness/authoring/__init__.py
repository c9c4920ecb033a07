"""Building blocks for plugin authors, which the core itself does not use. docs/authoring.md explains each name."""

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.authoring.act_without_learning import act_for
    from harness.authoring.folder_parts import Part, add_part, add_parts, parts_of
    from harness.authoring.generator_state import pack_generator, restore_generator
    from harness.authoring.ground_contact import GroundContact
    from harness.authoring.layers import layer_weights
    from harness.authoring.observed_reward import ObservedReward
    from harness.authoring.servo_track import ServoTrack
    from harness.authoring.substeps import Substeps
    from harness.authoring.wrapped_reward import WrappedReward
    from harness.experiment.jobs import events_of, order_of, run_job, run_jobs
    from harness.policy import Categorical, Deterministic, Gaussian, Greedy, SquashedGaussian
    from harness.robot.inverse_kinematics import reach_position
    from harness.robot.kinematics import forward, link_frames
    from harness.simulator import servo_of

__all__ = [
    "Categorical",
    "Deterministic",
    "Gaussian",
    "Greedy",
    "GroundContact",
    "ObservedReward",
    "Part",
    "ServoTrack",
    "SquashedGaussian",
    "Substeps",
    "WrappedReward",
    "act_for",
    "add_part",
    "add_parts",
    "events_of",
    "forward",
    "layer_weights",
    "link_frames",
    "order_of",
    "pack_generator",
    "parts_of",
    "reach_position",
    "restore_generator",
    "run_job",
    "run_jobs",
    "servo_of",
]

_HOMES = {
    **dict.fromkeys(("Categorical", "Deterministic", "Gaussian", "Greedy", "SquashedGaussian"), "harness.policy"),
    **dict.fromkeys(("forward", "link_frames"), "harness.robot.kinematics"),
    **dict.fromkeys(("events_of", "order_of", "run_job", "run_jobs"), "harness.experiment.jobs"),
    **dict.fromkeys(("Part", "add_part", "add_parts", "parts_of"), "harness.authoring.folder_parts"),
    **dict.fromkeys(("pack_generator", "restore_generator"), "harness.authoring.generator_state"),
    "GroundContact": "harness.authoring.ground_contact",
    "ObservedReward": "harness.authoring.observed_reward",
    "ServoTrack": "harness.authoring.servo_track",
    "Substeps": "harness.authoring.substeps",
    "WrappedReward": "harness.authoring.wrapped_reward",
    "act_for": "harness.authoring.act_without_learning",
    "layer_weights": "harness.authoring.layers",
    "reach_position": "harness.robot.inverse_kinematics",
    "servo_of": "harness.simulator",
}
"""Old names, which still work for one minor version."""

__getattr__ = lazy_names(__name__, _HOMES)
