"""The arms that come with the harness: engines see the same ones, and their files are what they were."""

import hashlib

import mujoco
import pinocchio
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

import harness
from harness.robot import parse_urdf
from harness.robot.urdf import read_chain

DIGESTS = {
    "fd100": (
        "618b0d4d40b591f21b21a06cbab11e538bf9b73b66957981483ea1456a08a040",
        "5a35a2f14ff58938fcbd13c40a7b8732f40d657faa23df32a91e448b293454bc",
    ),
    "unity-arm": (
        "6d8d23cc17fea9693cdd35948ef3cb18b61e29c3a97f233d3325ab19bb48b914",
        "248facff7b5fed2da057795a716df541ab4ebe0415cfff404eacd425dda3c0bc",
    ),
}
"""SHA-256 of the URDF that engines read, and of the robot, in version 0.1.0."""


@pytest.fixture(scope="module", params=DIGESTS)
def name(request):
    """Of one arm."""
    return request.param


@pytest.fixture(scope="module")
def robot(name):
    """The arm."""
    return harness.load_robot(name)


@pytest.fixture(scope="module")
def model(robot):
    """The arm alone, every link a body of its own."""
    spec = mujoco.MjSpec.from_string(robot.urdf)
    spec.compiler.fusestatic = False
    return spec.compile()


def random_poses(robot):
    """Joint positions in the whole range, (200, dof)."""
    return default_rng(100).uniform(robot.lower, robot.upper, (200, robot.dof))


def test_urdf_and_digest_are_those_of_the_records(name, robot):
    """Records name the digest, so that a change in how robots are read must not change it."""
    assert (hashlib.sha256(robot.urdf.encode()).hexdigest(), robot.digest) == DIGESTS[name]


def test_end_effector_is_that_of_mujoco(robot, model, data):
    """On 200 random poses the end effector is where MuJoCo puts it."""
    for qpos in random_poses(robot):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        expected = data.body(robot.end_effector_link).xpos
        assert_allclose(robot.end_effector(qpos), expected, rtol=0.0, atol=1e-9)


def test_end_effector_and_jacobian_are_those_of_pinocchio(robot):
    """On 200 random poses the end effector is where Pinocchio puts it, and moves as Pinocchio says."""
    model = pinocchio.buildModelFromXML(robot.urdf)
    data = model.createData()
    frame = model.getFrameId(robot.end_effector_link)
    for qpos in random_poses(robot):
        jacobian = pinocchio.computeFrameJacobian(model, data, qpos, frame, pinocchio.LOCAL_WORLD_ALIGNED)
        pinocchio.updateFramePlacement(model, data, frame)
        assert_allclose(robot.end_effector(qpos), data.oMf[frame].translation, rtol=0.0, atol=1e-9)
        assert_allclose(robot.jacobian(qpos), jacobian[:3], rtol=0.0, atol=1e-9)


def test_velocity_limits_of_both_files_agree(robot):
    """The URDF's velocity limits are the largest speeds of robot.toml."""
    chain = read_chain(parse_urdf(robot.urdf), robot.end_effector_link)
    assert_allclose([joint.velocity for joint in chain if joint.kind != "fixed"], robot.max_speed, rtol=1e-15)
