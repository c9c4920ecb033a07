"""What a simulator must satisfy, in the order in which it is checked. Each check takes the simulator and a robot."""

from harness import load_robot
from harness.robot import Robot
from harness.simulator import Simulator

from ..contract import raise_first, settings_are_frozen, settings_survive_json
from .calls import (
    a_simulation_has_its_methods,
    an_env_in_a_batch_is_as_one_alone,
    arguments_are_copied,
    close_can_be_called_twice,
    envs_do_not_touch_one_another,
    every_env_does_what_it_was_told,
    nothing_is_kept_of_a_period,
    read_returns_the_state_of_the_last_call,
    reset_forgets_what_was_before,
    resting_arms_change_nothing,
    same_calls_give_same_states,
    states_are_not_the_callers_arrays,
    the_same_way_leads_to_the_same_place,
)
from .servos import (
    SERVO_CHECKS,
    drive_tracks_a_joint_ramp,
    parts_of_a_period_add_up,
    qvel_is_the_speed_of_a_steady_motion,
    servo_check,
    small_moves_move_every_joint,
)
from .states import (
    end_effector_is_that_of_the_robot,
    every_solid_touches_the_ground,
    frames_show_the_target,
    frames_were_tried,
    ground_contact_is_seen,
    ground_contact_is_the_envs_own,
    no_ground_contact_in_the_air,
    place_puts_the_arm_there_at_rest,
    render_gives_a_frame_or_says_why_not,
    reset_leaves_the_other_envs_alone,
    reset_puts_the_arm_there_at_rest,
    states_are_finite,
    states_are_float64_and_bool,
    states_have_the_declared_shapes,
)

SERVO_CONTRACT = servo_check(
    "sim-servo",
    (
        states_are_finite,
        reset_puts_the_arm_there_at_rest,
        place_puts_the_arm_there_at_rest,
        reset_leaves_the_other_envs_alone,
        end_effector_is_that_of_the_robot,
        ground_contact_is_seen,
        no_ground_contact_in_the_air,
        ground_contact_is_the_envs_own,
        arguments_are_copied,
        every_env_does_what_it_was_told,
        same_calls_give_same_states,
        reset_forgets_what_was_before,
        the_same_way_leads_to_the_same_place,
        an_env_in_a_batch_is_as_one_alone,
        envs_do_not_touch_one_another,
        resting_arms_change_nothing,
    ),
)

SIMULATOR_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    a_simulation_has_its_methods,
    states_have_the_declared_shapes,
    states_are_float64_and_bool,
    states_are_finite,
    reset_puts_the_arm_there_at_rest,
    place_puts_the_arm_there_at_rest,
    reset_leaves_the_other_envs_alone,
    end_effector_is_that_of_the_robot,
    drive_tracks_a_joint_ramp,
    qvel_is_the_speed_of_a_steady_motion,
    parts_of_a_period_add_up,
    small_moves_move_every_joint,
    ground_contact_is_seen,
    every_solid_touches_the_ground,
    no_ground_contact_in_the_air,
    ground_contact_is_the_envs_own,
    read_returns_the_state_of_the_last_call,
    arguments_are_copied,
    states_are_not_the_callers_arrays,
    every_env_does_what_it_was_told,
    same_calls_give_same_states,
    reset_forgets_what_was_before,
    the_same_way_leads_to_the_same_place,
    an_env_in_a_batch_is_as_one_alone,
    envs_do_not_touch_one_another,
    resting_arms_change_nothing,
    render_gives_a_frame_or_says_why_not,
    frames_show_the_target,
    nothing_is_kept_of_a_period,
    close_can_be_called_twice,
    SERVO_CONTRACT,
    *SERVO_CHECKS,
)

SIMULATOR_WARNINGS = (frames_were_tried,)


def check_simulator(simulator: Simulator, robot: Robot | None = None) -> None:
    """Run all `SIMULATOR_CHECKS`.

    Args:
        simulator: To be checked.
        robot: To be simulated; fd100 if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(SIMULATOR_CHECKS, simulator, robot or load_robot("fd100"))
