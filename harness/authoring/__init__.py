"""Building blocks for plugin authors, which the core itself does not use. docs/authoring.md explains most of them."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.authoring.act_without_learning import act_for as act_for
    from harness.authoring.folder_parts import (
        Part as Part,
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
    from harness.experiment.jobs import run_job as run_job, run_jobs as run_jobs
    from harness.record.dataset.open_dataset import DatasetFacts as DatasetFacts
    from harness.record.trace import episode_facts as episode_facts, trace_of as trace_of
    from harness.registry.allowed import (
        require_allowed as require_allowed,
        require_program as require_program,
    )
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.spec import unknown_name as unknown_name
    from harness.scene.picture import Camera as Camera, StillFrames as StillFrames
else:
    __all__, __getattr__ = face_of(__name__, __file__)
