"""The resting pose of an arm that names none."""

from dataclasses import replace

import numpy as np
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from harness.robot import Shape, build_solids, link_frames
from harness.robot.kinematics import build_chain, end_effector_position
from harness.robot.resting_pose import choose_home
from harness.robot.urdf import Joint
from tests.refusals import refused


def joint(axis, z, lower=-2.0, upper=2.0):
    """A joint that turns, `z` above the one before."""
    return Joint("j", "revolute", "a", "b", (0.0, 0.0, z), (0.0, 0.0, 0.0), axis, lower, upper, 1.0)


TIP = Joint("t", "fixed", "a", "b", (0.0, 0.0, 0.4), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 0.0, None)


def upright(*, elbow=2.0):
    """An arm of three joints that at zero stands straight up: singular."""
    joints = [joint((0.0, 0.0, 1.0), 0.3), joint((0.0, 1.0, 0.0), 0.1), joint((0.0, 1.0, 0.0), 0.4, -elbow, elbow)]
    return build_chain([*joints, TIP])


def home_of(chain, lower=(-2, -2, -2), upper=(2, 2, 2), shapes=((), (), ())):
    """The pose chosen at 1 rad/s."""
    return choose_home(chain, np.array(lower), np.array(upper), np.ones(3), 0.9, shapes)


def test_middle_is_taken_where_it_is_good():
    """An arm that is bent in the middle of its ranges rests there."""
    assert_allclose(home_of(upright(), [-2, 0.4, 1.5], [2, 0.6, 1.7]), [0.0, 0.5, 1.6])


def test_straight_arm_is_bent_forward():
    """At zero it is stretched out; of the simplest bent poses the one with the tip in front is taken."""
    home = home_of(upright())
    assert home[0] == 0.0
    assert np.count_nonzero(home) == 1
    assert end_effector_position(upright(), home)[0] > 0.1


def test_no_joint_bends_by_more_than_90_degrees():
    """Half way to the end of a wide range would be far from what is usual. The first joint stays in the middle."""
    home = home_of(upright(), [-6, -6, -6], [6, 6, 6])
    assert np.abs(home).max() <= np.pi / 2
    assert home[0] == 0.0


def test_home_is_agile():
    """By differences of the tip's position: more than half as agile as the best of a thousand poses anywhere."""

    def agility(qpos):
        steps = 1e-6 * np.eye(3)
        ways = [
            end_effector_position(upright(), qpos + it) - end_effector_position(upright(), qpos - it) for it in steps
        ]
        return float(np.linalg.svd(np.array(ways) / 2e-6)[1][-1])

    anywhere = default_rng(0).uniform(-2.0, 2.0, (1000, 3))
    assert agility(home_of(upright())) > 0.55 * max(map(agility, anywhere))


def mounted(chain, mount):
    """The chain on another mount."""
    joints = chain.T_previous_joint.copy()
    joints[0] = mount @ joints[0]
    return replace(chain, T_previous_joint=joints, T_world_mount=mount)


WITH_ROD = [-2, -2, -1], [2, 1, 2], ([], [], [Shape("box", (0.02, 0.02, 0.5), np.eye(4))])
"""Ranges whose middle is no rest, and a last link."""
LONG_ROD = ([], [], [Shape("box", (0.02, 0.02, 1.2), np.eye(4))])


@given(rotvec=st.tuples(*[st.floats(-3.0, 3.0)] * 3), aside=st.tuples(*[st.floats(-5.0, 5.0)] * 2))
def test_home_follows_the_mount(rotvec, aside):
    """Far above the ground an arm rests as it does on the floor, whichever way it is mounted."""
    mount = np.eye(4)
    mount[:3, :3], mount[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), (*aside, 9.0)
    on_floor = home_of(upright(), *WITH_ROD)
    assert_array_equal(home_of(mounted(upright(), mount), *WITH_ROD), on_floor)


def test_home_keeps_away_from_a_ground_that_is_near():
    """On a wall half a metre above the ground the arm does not rest as it does elsewhere, where it would be in it."""
    mount = np.eye(4)
    mount[:3, :3], mount[2, 3] = Rotation.from_euler("y", 90, degrees=True).as_matrix(), 0.35
    on_floor, chain = home_of(upright(), *WITH_ROD), mounted(upright(), mount)
    assert end_effector_position(chain, on_floor)[2] < 0.09
    assert end_effector_position(chain, home_of(chain, *WITH_ROD))[2] >= 0.09


def test_home_is_far_from_the_ground_for_what_random_actions_do():
    """Of poses that are as agile the one is taken around which fewer are in the ground."""
    home = home_of(upright(), shapes=LONG_ROD)
    drifts = default_rng(0).uniform(-0.9, 0.9, (300, 3))
    solids, bends = build_solids(LONG_ROD), (-np.pi / 4, 0.0, np.pi / 4)
    others = [np.array([0.0, one, other]) for one in bends for other in bends]
    in_ground = [solids.touch_ground(link_frames(upright(), pose + drifts)).sum() for pose in (home, *others)]
    assert in_ground[0] <= np.median(in_ground)
    assert 2 * in_ground[0] < max(in_ground)


def test_arm_that_faces_another_way_rests_there():
    """The first joint stays in the middle of its range: this one looks along +y, and the tip is before it."""
    home = home_of(upright(), [np.pi / 2 - 1, -2, -2], [np.pi / 2 + 1, 2, 2])
    x, y, _ = end_effector_position(upright(), home)
    assert abs(x) < 1e-9
    assert abs(y) > 0.2


def test_home_is_clear_of_the_ground():
    """A pose that is simpler and puts a link into the ground is passed over."""
    low, high = [-2, 1.5, -1.5], [2, 2.5, 1.5]  # in the middle the tip is below the ground
    home = home_of(upright(), low, high)
    assert end_effector_position(upright(), home)[2] >= 0.09
    rod, other = build_solids(LONG_ROD), home_of(upright(), low, high, LONG_ROD)
    assert rod.lowest(link_frames(upright(), other[None]))[0] >= 0.09
    assert rod.lowest(link_frames(upright(), home[None]))[0] < 0.09


def test_turret_may_be_close_to_the_ground():
    """A link that never gets higher need not be a tenth of the arm above it, only not in it."""
    home = home_of(upright())
    turret = [[Shape("box", (0.2, 0.2, 0.59), np.eye(4))], [], []]  # 5 mm above
    assert_array_equal(home_of(upright(), shapes=turret), home)


def test_arm_in_the_ground_is_refused():
    """An arm whose links stand in the ground in any pose is told so in one line."""
    plate = [[Shape("box", (1.0, 1.0, 2.0), np.eye(4))], [], []]
    with refused(r"moving links 0\.09 m above the ground z = 0\. In a robot\.toml, .*: base = { xyz_m = \["):
        home_of(upright(), shapes=plate)


def test_arm_in_a_plane_has_a_home():
    """Three parallel axes never move the tip sideways: no pose is agile, and one is taken all the same."""
    chain = build_chain([joint((0.0, 1.0, 0.0), 0.3) for _ in range(3)] + [TIP])
    assert np.isfinite(home_of(chain)).all()
