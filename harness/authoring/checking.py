"""What checks of plugins are written with: worlds to try them in, and the parts that they are built of.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.authoring.closed_motion import closed_motion as closed_motion
    from harness.env.ideal import LoggedSimulation as LoggedSimulation
    from harness.env.vector_env import Actions as Actions, Infos as Infos
    from harness.experiment.checkpoints.checkpoint import (
        Checkpoint as Checkpoint,
        read_checkpoint as read_checkpoint,
        store as store,
    )
    from harness.experiment.environments.plan import (
        RandomStep as RandomStep,
        random_steps as random_steps,
        value_of as value_of,
    )
    from harness.experiment.environments.spaces import (
        ACHIEVED as ACHIEVED,
        DESIRED as DESIRED,
        flat_observations as flat_observations,
        goal_columns as goal_columns,
        kind_of_actions as kind_of_actions,
    )
    from harness.experiment.workers.worker import print_into as print_into
    from harness.experiment.workers.workers import Offspring as Offspring, Pool as Pool
    from harness.log.format import HEAD as HEAD
    from harness.record.trace import (
        FLAGS as FLAGS,
        INTEGERS as INTEGERS,
        NOTHING_KNOWN as NOTHING_KNOWN,
        NUMBERS as NUMBERS,
        OBSTACLE as OBSTACLE,
        QVEL as QVEL,
        with_episode_facts as with_episode_facts,
    )
    from harness.recorder.column import Column as Column, made_columns as made_columns
    from harness.registry.given import PluginFile as PluginFile, is_class_name as is_class_name
    from harness.registry.targets import why_unfit as why_unfit
    from harness.reward.forms import is_plain_function as is_plain_function
    from harness.reward.given import Untold as Untold
    from harness.reward.steps import (
        DISTANCE as DISTANCE,
        map_steps as map_steps,
        rows_of as rows_of,
        step_between as step_between,
    )
    from harness.reward.terms import SIZES as SIZES, call_noted as call_noted, made_up as made_up
    from harness.robot.energy import energy as energy
    from harness.robot.robot import is_path as is_path
    from harness.robot.settings import FILE as FILE

else:
    __all__, __getattr__ = face_of(__name__, __file__)
