"""Arms that the harness does not bring: published ones with meshes, and drawn ones with joints that slide."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pybullet
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness.robot import build_solids, link_frames
from harness.robot.robot import read_robot
from harness_plugins.bullet_arms import Clients, FreeArm, file_of_arm
from harness_plugins.kit.simulators.checks import SIMULATOR_CHECKS
from harness_plugins.kit.simulators.states import frames_show_the_target, render_gives_a_frame_or_says_why_not
from harness_plugins.mujoco_model import build_model
from harness_plugins.simulators.kinematic import Kinematic
from harness_plugins.simulators.mujoco import Mujoco
from tests.refusals import refused
from tests.registered import REGISTRY
from tests.robot.brought_arms import ARM, BODY, changed, read_arm
from tests.robot.test_meshes import CORNERS, collada

PUBLISHED = {
    "panda": ("franka_panda/panda.urdf", "panda_grasptarget", 7),
    "iiwa": ("kuka_iiwa/model.urdf", "lbr_iiwa_link_7", 7),
    "xarm6": ("xarm/xarm6_robot.urdf", "link6", 6),
}
"""File in pybullet_data, end effector and number of joints."""
ARMS = [*PUBLISHED, "scara", "gantry"]
ENGINES = [name for name in ("mujoco", "pybullet", "drake", "physx") if not REGISTRY.get("simulators", name).missing]
SIMULATORS = [REGISTRY.get("simulators", name).load()() for name in (*ENGINES, "kinematic")]
"""Those that are installed; the kinematic one, which takes many poses at once, comes last."""
FRAME_CHECKS = {render_gives_a_frame_or_says_why_not, frames_show_the_target}
CHECKS = [check for check in SIMULATOR_CHECKS if check not in FRAME_CHECKS]

SCARA = [
    ("revolute", "0 0 1", "0 0 0.4", 2.5), ("revolute", "0 0 1", "0.3 0 0", 2.5),
    ("prismatic", "0 0 1", "0.3 0 0", 0.45),
]  # fmt: skip
GANTRY = [
    ("prismatic", "1 0 0", "0 0 1", 0.6), ("prismatic", "0 1 0", "0 0 0", 0.6), ("prismatic", "0 0 1", "0 0 0", 0.6),
    ("revolute", "0 0 1", "0 0 -0.1", 3.0), ("revolute", "0 1 0", "0 0 -0.1", 2.0),
    ("revolute", "0 1 0", "0 0 -0.2", 2.0), ("continuous", "0 0 1", "0 0 -0.1", 0.0),
    ("revolute", "1 0 0", "0 0 -0.1", 2.0),
]  # fmt: skip
"""Kind, axis, origin and range of each joint."""


def drawn(joints):
    """A URDF of boxes; every third link has no mass."""
    text, parent = '<robot name="drawn"><link name="base"/>', "base"
    for number, (kind, axis, origin, reach) in enumerate(joints):
        mass = '<mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
        inertial = f"<inertial>{mass}</inertial>" if (number + 1) % 3 else ""
        box = '<collision><geometry><box size="0.04 0.04 0.1"/></geometry></collision>'
        limit = f'<limit lower="{-reach}" upper="{reach}" velocity="{0.5 if kind == "prismatic" else 2}" effort="0"/>'
        text += (
            f'<link name="l{number}">{inertial}{box}</link><joint name="j{number}" type="{kind}">{limit}'
            f'<parent link="{parent}"/><child link="l{number}"/><origin xyz="{origin}"/><axis xyz="{axis}"/></joint>'
        )
        parent = f"l{number}"
    tip = (
        f'<joint name="mount" type="fixed"><parent link="{parent}"/><child link="tip"/><origin xyz="0 0 -0.1"/></joint>'
    )
    return f'{text}<link name="tip"/>{tip}</robot>'


@pytest.fixture(scope="module", params=ARMS)
def robot(request, tmp_path_factory):
    """One arm."""
    if request.param in PUBLISHED:
        return published(request.param)
    path = tmp_path_factory.mktemp("drawn") / f"{request.param}.urdf"
    path.write_text(drawn({"scara": SCARA, "gantry": GANTRY}[request.param]))
    return read_robot(path)


def published(name):
    """An arm that comes with pybullet."""
    data = pytest.importorskip("pybullet_data", reason="the published arms come with pybullet's data")
    return read_robot(Path(data.getDataPath(), PUBLISHED[name][0]))


def poses(robot, count):
    """Joint positions in the whole range, (count, dof)."""
    return default_rng(1).uniform(robot.lower, robot.upper, (count, robot.dof))


@pytest.fixture
def bullet():
    """A client."""
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


@pytest.mark.parametrize("name", PUBLISHED)
def test_end_effector_and_joints_of_a_published_arm(name):
    """The end is the flange, or the tool's frame on the hand; fingers are no joints of the arm."""
    robot = published(name)
    assert (robot.end_effector_link, robot.dof) == PUBLISHED[name][1:]
    assert not robot.chain.slides.any()


@pytest.mark.parametrize("name", PUBLISHED)
def test_kinematics_is_that_of_the_published_file(name, bullet):
    """Where Bullet, reading the maker's own file, puts the end effector, to 1e-6 m."""
    robot = published(name)
    pybullet.setAdditionalSearchPath(pytest.importorskip("pybullet_data").getDataPath(), physicsClientId=bullet)
    body = pybullet.loadURDF(PUBLISHED[name][0], useFixedBase=True, physicsClientId=bullet)
    count = pybullet.getNumJoints(body, physicsClientId=bullet)
    infos = [pybullet.getJointInfo(body, k, physicsClientId=bullet) for k in range(count)]
    joints = {info[1].decode(): info[0] for info in infos}
    (tip,) = (info[0] for info in infos if info[12].decode() == robot.end_effector_link)
    for qpos in poses(robot, 50):
        for joint, position in zip(robot.joint_names, qpos, strict=True):
            pybullet.resetJointState(body, joints[joint], position, physicsClientId=bullet)
        state = pybullet.getLinkState(body, tip, computeForwardKinematics=1, physicsClientId=bullet)
        assert_allclose(robot.end_effector(qpos), state[4], atol=1e-6)


def test_kinematics_is_that_of_the_mujoco_model(robot):
    """Where MuJoCo puts the end effector, to 1e-9 m."""
    model = build_model(robot, 0.005, 100.0)
    data = mujoco.MjData(model)
    for qpos in poses(robot, 50):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        assert_allclose(robot.end_effector(qpos), data.body(robot.end_effector_link).xpos, atol=1e-9)


def test_home_is_clear_of_the_ground(robot):
    """At home, by the rules, nothing touches the ground in any simulator, and every joint has room to move."""
    for simulator in SIMULATORS:
        simulation = simulator.open(robot, 1, 0.1)
        assert not simulation.place(robot.home[None]).ground_contact.any()
        simulation.close()
    assert ((robot.lower < robot.home) & (robot.home < robot.upper)).all()


def test_simulators_agree_on_ground_contact(robot):
    """Poses touch the ground in all simulators or in none, but for those within 3 mm of it."""
    qpos = poses(robot, 200)
    simulations = [
        simulator.open(robot, len(qpos) if isinstance(simulator, Kinematic) else 1, 0.1) for simulator in SIMULATORS
    ]
    touching = simulations[-1].place(qpos).ground_contact.copy()
    certain = np.flatnonzero(np.abs(_height(robot, qpos)) > 3e-3)
    assert 5 < touching.sum() < 195
    for simulation in simulations[:-1]:
        contacts = [bool(simulation.place(qpos[k : k + 1]).ground_contact[0]) for k in certain]
        assert_array_equal(contacts, touching[certain])
    for simulation in simulations:
        simulation.close()


def _height(robot, qpos):
    """Of the lowest point of the moving links, (n,), [m]."""
    return build_solids(robot.joint_shapes).lowest(link_frames(robot.chain, qpos))


@pytest.mark.parametrize("simulator", SIMULATORS, ids=lambda simulator: type(simulator).__name__)
@pytest.mark.parametrize(
    "robot", [pytest.param(it, marks=[pytest.mark.slow] * (it not in {"iiwa", "gantry"})) for it in ARMS], indirect=True
)
def test_simulators_keep_the_contract(robot, simulator):
    """With an arm of meshes, and with one whose joints slide and turn without end: all checks but those of frames."""
    for check in CHECKS:
        check(simulator, robot)


def test_episodes_of_a_published_arm(subtests):
    """The reach task takes the path of a URDF: it starts in the air, moves the arm, and gives numbers."""
    for simulator in [*ENGINES, "kinematic"]:
        for name in PUBLISHED:
            with subtests.test(simulator=simulator, name=name):
                data = pytest.importorskip("pybullet_data")
                env = harness.make_env(simulator, robot=Path(data.getDataPath(), PUBLISHED[name][0]), num_envs=2)
                first, _ = env.reset(seed=0)
                for _ in range(10):
                    observation, reward, *_ = env.step(env.action_space.sample())
                    assert np.isfinite(observation).all()
                    assert np.isfinite(reward).all()
                env.close()
                assert np.abs(observation - first).max() > 0.01


def test_what_mujoco_cannot_read_is_refused_in_one_line(tmp_path):
    """The answer names the robot."""
    (tmp_path / "arm.urdf").write_text(drawn(SCARA))
    robot = read_robot(tmp_path / "arm.urdf")
    broken = replace(robot, urdf=robot.urdf.replace('<mass value="', '<mass value="heavy'))
    with refused("MuJoCo cannot load the URDF of robot 'arm': "):
        Mujoco().open(broken, 1, 0.1)


@pytest.mark.parametrize("simulator", SIMULATORS, ids=lambda it: type(it).__name__)
def test_a_flat_mesh_collides(tmp_path, simulator):
    """A marker's plate, of which MuJoCo alone could build no hull: it is solid in every simulator."""
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv .2 0 -1\nv 0 .1 -1\nf 1 2 3\n")
    shape = '<collision><geometry><mesh filename="flat.obj"/></geometry></collision>'
    (tmp_path / "flat.urdf").write_text(drawn(SCARA).replace('<link name="l2">', f'<link name="l2">{shape}'))
    (tmp_path / "robot.toml").write_text("home_deg = [0, 0]\nhome_m = [0.2]\n")
    robot = read_robot(tmp_path / "flat.urdf")
    with closing(simulator.open(robot, 1, 0.1)) as simulation:
        assert simulation.reset(robot.home[None], np.ones(1, bool)).ground_contact.all()


ODD = {
    "base": ("1", (1, 1, 1, 0, 0, 0)),
    "l1": ("2", (3, 4, 5, 1, -1, 0.5)),
    "l2": ("2", (1, 1, 9, 0, 0, 0)),
    "l3": ("2", (0, 0, 0, 0, 0, 0)),
    "l4": ("0", (1, 1, 1, 0, 0, 0)),
}
"""Mass and moments that engines read in different ways, by the link: xx, yy, zz, xy, xz, yz."""

AXES = ("xx", "yy", "zz", "xy", "xz", "yz")


def test_engines_have_the_inertia_that_is_told(tmp_path):
    """The mass matrices of MuJoCo and Bullet are Pinocchio's of the same URDF, of the given one they would not be."""
    text = ARM
    for link, (mass, moments) in ODD.items():
        given = " ".join(f'i{axes}="{moment}"' for axes, moment in zip(AXES, moments, strict=True))
        inertial = f'<inertial><origin rpy="1 2 3"/><mass value="{mass}"/><inertia {given}/></inertial>'
        text = changed((f'<link name="{link}">{BODY}', f'<link name="{link}">{inertial}'), text=text)
    robot, qpos = read_arm(tmp_path, text), np.array([0.3, -0.4, 0.5, 0.6])
    assert "link 'l3' with a principal moment of 0 or less; link 'l2' with one larger" in "".join(robot.warnings)
    plain, given = (_inertia_by_pinocchio(urdf, qpos) for urdf in (robot.urdf, text))
    with closing(Clients(robot)) as clients, file_of_arm(robot) as path:
        bullet = FreeArm(clients.connect(), robot, path, np.zeros(4)).inertia(list(qpos))
    model = build_model(robot, 0.01, 20.0)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    columns = np.zeros((4, 4))
    for column, unit in zip(columns, np.eye(4), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    assert_allclose(columns - np.diag(model.dof_armature), plain, atol=1e-9)
    assert_allclose(bullet, plain, atol=1e-9)
    assert np.abs(given - plain).max() > 1.0


def _inertia_by_pinocchio(urdf, qpos):
    model = pinocchio.buildModelFromXML(urdf)
    upper = np.triu(pinocchio.crba(model, model.createData(), qpos))
    return upper + np.triu(upper, 1).T


@pytest.mark.parametrize("drawing", [None, "<COLLADA/>", collada(CORNERS)], ids=["missing", "broken", "whole"])
def test_drawing_does_no_harm(tmp_path, drawing):
    """Every simulator opens the arm whatever its drawing is. What can be read stays."""
    shape = '<visual><geometry><mesh filename="nice.dae"/></geometry></visual>'
    path = tmp_path / "seen.urdf"
    path.write_text(drawn(SCARA).replace('<link name="l2">', f'<link name="l2">{shape}'))
    if drawing is not None:
        (tmp_path / "nice.dae").write_text(drawing)
    robot = read_robot(path)
    assert ("drawing is left out" in "".join(robot.warnings)) == (drawing != collada(CORNERS))
    for simulator in SIMULATORS:
        simulator.open(robot, 1, 0.1).close()
