"""PyBullet: contact that is exact, motors that forget, clients that are given back, files that cannot be read."""

from contextlib import closing
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pybullet
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose

import harness
from harness.robot import Shape, parse_urdf
from harness.robot.normal_urdf import normal_urdf
from harness_plugins.bullet_arms import Clients, FreeArm, arm as bullet_arm, exact_timestep, file_of_arm
from harness_plugins.simulators.pybullet import PyBullet
from tests.plugins.simulators.conftest import (
    PERIOD,
    ROBOT,
    assert_same,
    home,
    lowest_height,
    only_shape_of,
    random_poses,
)
from tests.refusals import refused
from tests.robot.brought_arms import ARM, changed, read_arm


def test_every_period_has_its_substeps(subtests):
    """A period is so many equal physics steps that nothing is left for the next, whatever is divided by what."""
    for substeps in [1, 3, 7, 20, 33]:
        for period in [0.1, 0.06, 1.0 / 30.0]:
            with subtests.test(substeps=substeps, period=period):
                step = exact_timestep(period, substeps)
                assert step == pytest.approx(period / substeps, rel=1e-7)
                assert (step * substeps) / substeps == step
                assert (step * substeps) % step == 0.0


@pytest.mark.parametrize(("needed", "off"), [(None, (0.0, 1e-3)), (1, (5e-3, 1.0))])
def test_a_heavy_tool_gets_the_iterations_that_it_needs(needed, off, open_arms, monkeypatch):
    """With the FD100's 50 its tip is centimetres from where it is driven, with what the arm needs it is there.

    Its links weigh 10 g, and the last one, which is small, weighs 20 kg.
    """
    urdf = ElementTree.fromstring(ROBOT.urdf)
    inertials = urdf.findall("link/inertial")
    for inertial in inertials:
        inertial.find("mass").set("value", "20" if inertial is inertials[-1] else "1e-2")  # type: ignore[union-attr]
        for key in ("ixx", "iyy", "izz"):
            inertial.find("inertia").set(key, "3e-3")  # type: ignore[union-attr]
    light = replace(ROBOT, urdf=ElementTree.tostring(urdf, encoding="unicode"))
    if needed is not None:
        monkeypatch.setattr(bullet_arm, "needed_iterations", lambda *_: needed)
    simulation = open_arms(1, robot=light)
    turn = 0.2 * light.max_speed * PERIOD * [1, -1, 1, -1, 1, -1]
    errors = []
    for step in range(1, 11):
        target = light.home + step * turn
        errors.append(norm(simulation.drive(target[None], PERIOD).end_effector - light.end_effector(target)))
    assert off[0] <= max(errors) < off[1]


@pytest.mark.parametrize("name", ["fd100", "unity-arm"])
def test_the_robots_of_this_project_need_no_more_iterations_than_their_records_have(name):
    """These were made with 50."""
    robot = harness.load_robot(name)
    simulation = PyBullet().open(robot, 1, PERIOD)
    (arm,) = simulation.arms
    assert bullet_arm.needed_iterations(arm.client, arm.body, robot) <= 50
    simulation.close()


@pytest.mark.parametrize("substeps", [3, 7, 20])
def test_bullet_takes_all_substeps_at_once(substeps, open_arms):
    """One call for a period gives what a call for each physics step gives, bit for bit."""
    at_once, one_by_one = (open_arms(1, period=0.06, substeps=substeps) for _ in range(2))
    (arm,) = one_by_one.arms
    for period in range(30):
        target = home(1) + 0.2 * np.sin(0.2 * period)
        speeds = (target - one_by_one.read().qpos)[0] / 0.06
        step_alone(arm, speeds.tolist(), exact_timestep(0.06, substeps), substeps)
        arm.read(one_by_one.read(), 0)
        assert_same([at_once.drive(target, 0.06)], [one_by_one.read()])


def step_alone(arm, speeds, step, substeps):
    """Turn an arm, calling Bullet for each physics step."""
    client = {"physicsClientId": arm.client}
    pybullet.setPhysicsEngineParameter(fixedTimeStep=step, numSubSteps=0, **client)
    pybullet.setJointMotorControlArray(
        arm.body, arm.joints, pybullet.VELOCITY_CONTROL, targetVelocities=speeds, forces=arm.forces, **client
    )
    for _ in range(substeps):
        pybullet.stepSimulation(**client)


@pytest.mark.parametrize("height", [2e-4, -1e-3])
def test_ground_contact_is_exact(height, open_arms):
    """An arm that is placed 0.2 mm above the ground does not touch it, also after it did; one 1 mm below does."""
    simulation, inside = open_arms(1), [pose for pose in random_poses(200) if lowest_height(pose) < -0.05]
    assert len(inside) > 30
    for pose in inside:
        placed = pose_at_height(height, pose)
        for _ in range(2):
            assert simulation.place(placed[None]).ground_contact[0] == (height < 0.0)
            simulation.drive((placed + 0.02 * (pose - placed))[None], PERIOD)


# Bullet rounds edges: corners of boxes end up to 0.7 mm early.
def pose_at_height(height, inside):
    """The pose between home and one below the ground whose lowest point is at a height [m], to a micrometre."""
    above, below = ROBOT.home, inside
    while np.abs(above - below).max() > 1e-7:
        middle = (above + below) / 2.0
        above, below = (middle, below) if lowest_height(middle) > height else (above, middle)
    return above


def test_end_effector_is_the_frame_of_its_link(open_arms):
    """On 200 random poses the end effector is where the robot's kinematics put it, to single precision."""
    poses, simulation = random_poses(200), open_arms(1)
    told = np.array([simulation.place(pose[None]).end_effector[0].copy() for pose in poses])
    assert_allclose(told, ROBOT.end_effector(poses), atol=3e-7)


def test_link_without_inertia_weighs_nothing(open_arms):
    """A link to which the URDF gives no inertia is not given 1 kg by Bullet, and nothing is printed about it."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    for link in tree.findall("link[@name='tool0']"):
        for inertial in link.findall("inertial"):
            link.remove(inertial)
    plain = normal_urdf(parse_urdf(ElementTree.tostring(tree, "unicode")), ROBOT.joint_names, ROBOT.folder).urdf
    simulation = open_arms(1, replace(ROBOT, urdf=plain.text))
    (arm,) = simulation.arms  # which its simulation keeps open
    assert pybullet.getDynamicsInfo(arm.body, arm.tip, physicsClientId=arm.client)[0] < 1e-5


HEAVY = (
    ("0.3 -0.4 0.3", 'value="747"', 'ixx="100" iyy="150" izz="170" ixy="-5" ixz="-7" iyz="8"'),
    ("0.4 0.3 0.4", 'value="1491"', 'ixx="100" iyy="150" izz="170" ixy="-10" ixz="11" iyz="-12"'),
)
"""Of links: the centre of mass, the mass, the moments. Bullet's own dynamics refuse arms of them."""


def heavy_arm(folder, centre, mass, moments):
    """An arm with one of these links."""
    text = changed(
        ('xyz="0 0 0.1"/><mass', f'xyz="{centre}"/><mass'), ('value="1.0"', mass),
        ('ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"', moments),
    )  # fmt: skip
    return read_arm(folder, text)


@pytest.mark.parametrize("link", HEAVY)
def test_dynamics_of_a_heavy_arm(tmp_path, monkeypatch, link):
    """They are Pinocchio's, though Bullet takes the rounding of such an inertia for a mistake."""
    robot = heavy_arm(tmp_path, *link)
    model = pinocchio.buildModelFromXML(robot.urdf)
    qpos, qvel = [0.3, -0.4, 0.5, 0.6], [1.0, -2.0, 3.0, 0.5]
    upper = np.triu(pinocchio.crba(model, model.createData(), np.array(qpos)))
    bias = pinocchio.nle(model, model.createData(), np.array(qpos), np.array(qvel))
    with closing(Clients(robot)) as clients, file_of_arm(robot) as path:
        free = FreeArm(clients.connect(), robot, path, np.zeros(4))
        assert_allclose(free.inertia(qpos), upper + np.triu(upper, 1).T, rtol=1e-9, atol=1e-9 * upper.max())
        assert_allclose(free.bias(qpos, qvel), bias, rtol=1e-9, atol=1e-9 * np.abs(bias).max())
        monkeypatch.setattr("harness_plugins.bullet_arms.free_arm.HEAVY", np.inf)
        with pytest.raises(SystemError):
            FreeArm(clients.connect(), robot, path, np.zeros(4)).inertia(qpos)


def test_a_heavy_arm_is_driven_where_it_is_told(tmp_path):
    """What its solver needs is asked of a lighter one; its masses are those of the URDF afterwards."""
    robot = heavy_arm(tmp_path, *HEAVY[0])
    simulation = PyBullet().open(robot, 1, PERIOD)
    with closing(simulation):
        simulation.reset(robot.home[None], np.ones(1, bool))
        target = robot.home + 0.05
        assert np.abs(simulation.drive(target[None], PERIOD).qpos - target).max() < 5e-3
        (arm,) = simulation.arms
        assert pybullet.getDynamicsInfo(arm.body, 0, physicsClientId=arm.client)[0] == 747.0


LONG = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, -3.0]]


def test_mesh_is_found_from_the_folder_of_the_robot(tmp_path, open_arms):
    """A mesh whose path starts from the robot's folder reaches the ground."""
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in LONG)
    (tmp_path / "long.obj").write_text(f"{points}f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
    robot = with_mesh(tmp_path, "long.obj")
    plain = normal_urdf(parse_urdf(robot.urdf), robot.joint_names, tmp_path).urdf
    assert open_arms(1, replace(robot, urdf=plain.text)).read().ground_contact.all()


def test_missing_mesh_is_a_usage_error(tmp_path, capfd, open_arms):
    """A mesh that is not there is a usage error that names the robot; what Bullet prints of it goes to stderr."""
    with refused("cannot load the URDF of robot 'fd100'"):
        open_arms(1, with_mesh(tmp_path, "none.obj"))
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "none.obj" in printed.err


def with_mesh(folder, filename):
    """The arm with a mesh of the points `LONG` as the only shape of its first moving link."""
    bare = only_shape_of("none")
    tree = ElementTree.fromstring(bare.urdf)
    shape = f'<collision><geometry><mesh filename="{filename}"/></geometry></collision>'
    tree.find("link[@name='link1']").append(ElementTree.fromstring(shape))
    solids = {**bare.link_shapes, "link1": (Shape("mesh", (), np.eye(4), np.array(LONG)),)}
    return replace(bare, urdf=ElementTree.tostring(tree, "unicode"), folder=folder, link_shapes=solids)


def test_too_many_clients_are_a_usage_error(monkeypatch, open_arms):
    """Where Bullet opens no more clients, one line says what to do."""

    def refuse(_):
        raise pybullet.error("Exceeding maximum number of physics connections.")

    monkeypatch.setattr(pybullet, "connect", refuse)
    with refused("take fewer envs"):
        open_arms(1)


@pytest.mark.parametrize("render", [False, True])
def test_close_gives_all_clients_back(render, open_arms):
    """After `close` no client is connected, that of the frames included; a second call does nothing."""
    simulation = open_arms(2)
    if render:
        simulation.render(0, np.zeros(3), 32, 24)
    clients = list(simulation._frames.numbers)
    assert len(clients) == 2 + render
    simulation.close()
    simulation.close()
    assert not any(pybullet.isConnected(physicsClientId=client) for client in clients)


def test_simulation_that_nothing_holds_is_closed(open_arms):
    """Without `close`, the clients go with the simulation."""
    simulation = open_arms(1)
    (client,) = simulation._frames.numbers
    del simulation
    assert not pybullet.isConnected(physicsClientId=client)


def test_bullet_is_given_short_lines(tmp_path):
    """It breaks lines at 8,191 characters, within a name too, and then refuses the arm: xacro writes one line."""
    more = "".join(f'<transmission name="t{number}"><type>simple</type></transmission>' for number in range(200))
    with file_of_arm(read_arm(tmp_path, ARM.replace("\n", " ").replace("</robot>", f"{more}</robot>"))) as path:
        lines = path.read_text().splitlines()
    assert sum(map(len, lines)) > 8191 > max(map(len, lines))
