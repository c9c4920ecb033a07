"""Building blocks for plugin authors, which the core itself does not use. docs/authoring.md explains each name."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.authoring.act_without_learning import act_for as act_for
    from harness.authoring.folder_parts import (
        Part as Part,
        add_part as add_part,
        add_parts as add_parts,
        parts_of as parts_of,
    )
    from harness.authoring.generator_state import (
        pack_generator as pack_generator,
        restore_generator as restore_generator,
    )
    from harness.authoring.ground_contact import GroundContact as GroundContact
    from harness.authoring.layers import layer_weights as layer_weights
    from harness.authoring.observed_reward import ObservedReward as ObservedReward
    from harness.authoring.servo_track import ServoTrack as ServoTrack
    from harness.authoring.substeps import Substeps as Substeps
    from harness.authoring.wrapped_reward import WrappedReward as WrappedReward
    from harness.experiment.jobs import (
        events_of as events_of,
        order_of as order_of,
        run_job as run_job,
        run_jobs as run_jobs,
    )
    from harness.policy import (
        Categorical as Categorical,
        Deterministic as Deterministic,
        Gaussian as Gaussian,
        Greedy as Greedy,
        SquashedGaussian as SquashedGaussian,
    )
    from harness.robot.kinematics import (
        forward as forward,
        link_frames as link_frames,
        reach_position as reach_position,
    )
    from harness.simulator import servo_of as servo_of
else:
    __all__, __getattr__ = face_of(__name__, __file__)
