"""PyBullet: motors that track, contact of every moving link, worlds that forget, frames."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pybullet
import pytest

import harness
from harness.errors import UsageError
from harness.motion import MoveJ
from harness.robot import Robot
from harness.robot.normal_urdf import normal_urdf
from harness.robot.urdf import parse_urdf
from harness.simulator import Simulation, State
from harness_plugins.simulators.pybullet import PyBullet, exact_timestep

ROBOT = harness.load_robot("fd100")
PERIOD = 0.1
MOTION = MoveJ.within_limits(ROBOT, speed=0.8, acceleration=0.6, period=PERIOD)
MOVING_LINKS = ("link2", "link3", "link4", "link5", "link6", "tool0")
"""Those that can get to the ground: the first one turns above it."""
FALLEN = np.radians([[0.0, 120.0, 0.0, 0.0, 0.0, 0.0]])
"""A pose deep in the ground."""


def open_arms(num_envs: int, robot: Robot = ROBOT, period: float = PERIOD, **settings: int) -> Simulation:
    """Arms at home; the simulation closes itself when nothing holds it any more."""
    simulation = PyBullet(**settings).open(robot, num_envs, period)
    simulation.reset(home(num_envs), np.ones(num_envs, bool))
    return simulation


def home(num_envs: int) -> np.ndarray:
    """The home pose for each env."""
    return np.tile(ROBOT.home, (num_envs, 1))


def random_poses(count: int) -> np.ndarray:
    """Poses anywhere in the joint ranges."""
    return np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def copied(state: State) -> State:
    """A state that outlives the next call."""
    return State._make(np.array(array) for array in state)


def wander(simulation: Simulation, num_envs: int, periods: int, same: bool = False, seed: int = 0) -> list[State]:
    """Random moves at full speed, some of them held for a while; an arm that touches the ground is reset to home.

    Returns copies of the states, with the target of each joint in the place of `end_effector`.
    """
    rng = np.random.default_rng(seed)
    target, speed, states = home(num_envs), np.zeros((num_envs, ROBOT.dof)), []
    for period in range(periods):
        if period % 4 == 0:
            action = np.repeat(rng.uniform(-2.0, 2.0, (1 if same else num_envs, ROBOT.dof)), num_envs if same else 1, 0)
        (target,), speed, _ = MOTION.advance(target, speed, action)
        state = copied(simulation.drive(target, PERIOD))
        states.append(state._replace(end_effector=target))
        touching = state.ground_contact
        if touching.any():
            target, speed = np.where(touching[:, None], ROBOT.home, target), np.where(touching[:, None], 0.0, speed)
            simulation.reset(target, touching)
    return states


def assert_same(first: list[State], second: list[State]) -> None:
    """The states are the same, bit for bit."""
    for one, other in zip(first, second, strict=True):
        for array, another in zip(one, other, strict=True):
            np.testing.assert_array_equal(array, another)


@pytest.mark.parametrize("num_envs", [1, 8])
def test_joints_follow_random_moves_at_full_speed(num_envs: int):
    """Over hundreds of random moves no joint in the air is ever 0.05 degrees off its target."""
    states = wander(open_arms(num_envs), num_envs, periods=2400 // num_envs)
    errors = np.array([np.abs(state.qpos - state.end_effector) for state in states])
    in_the_air = ~np.array([state.ground_contact for state in states])
    speeds = np.array([np.abs(state.qvel) for state in states])[in_the_air]
    assert in_the_air.sum() > 1800
    assert (speeds.max(axis=0) > 0.95 * MOTION.limits.max_speed).all()
    assert np.degrees(errors[in_the_air].max()) < 0.05


def test_arm_that_is_told_to_stay_stays():
    """Gravity does not pull the arm down: after 10 s every joint is within a hundredth of a degree of home."""
    simulation = open_arms(1)
    for _ in range(100):
        state = simulation.drive(home(1), PERIOD)
    assert np.degrees(np.abs(state.qpos - ROBOT.home).max()) < 0.01


def test_errors_do_not_add_up():
    """After 1,000 small moves there and back the joints are where they began."""
    simulation = open_arms(1)
    for period in range(1000):
        simulation.drive(home(1) + 0.03 * np.sin(0.1 * (period + 1)), PERIOD)
    for _ in range(20):
        state = simulation.drive(home(1), PERIOD)
    assert np.degrees(np.abs(state.qpos - ROBOT.home).max()) < 0.01


def test_arm_that_was_held_up_by_the_ground_catches_up():
    """Targets below the ground, asked for over 2 s, are forgotten with the first target above it."""
    simulation = open_arms(1)
    for share in np.linspace(0.0, 1.0, 20):
        simulation.drive(home(1) + share * (FALLEN - home(1)), PERIOD)
    held = simulation.read().qpos.copy()
    assert np.degrees(np.abs(held - FALLEN).max()) > 5.0
    above = held + np.radians([[0.0, -5.0, 0.0, 0.0, 0.0, 0.0]])
    state = simulation.drive(above, PERIOD)
    assert np.degrees(np.abs(state.qpos - above).max()) < 0.5


@pytest.mark.parametrize("substeps", [1, 3, 7, 20, 33])
@pytest.mark.parametrize("period", [0.1, 0.06, 1.0 / 30.0])
def test_every_period_has_its_substeps(period: float, substeps: int):
    """A period is so many equal physics steps that nothing is left for the next, whatever is divided by what."""
    step = exact_timestep(period, substeps)
    assert step == pytest.approx(period / substeps, rel=1e-7)
    assert (step * substeps) / substeps == step
    assert (step * substeps) % step == 0.0


@pytest.mark.parametrize("substeps", [3, 7, 20])
def test_bullet_takes_all_substeps_at_once(substeps: int):
    """One call for a period gives what a call for each physics step gives, bit for bit."""
    at_once, one_by_one = (open_arms(1, period=0.06, substeps=substeps) for _ in range(2))
    (arm,) = one_by_one.arms
    for period in range(30):
        target = home(1) + 0.2 * np.sin(0.2 * period)
        speeds = (target - one_by_one.read().qpos)[0] / 0.06
        step_alone(arm, speeds.tolist(), exact_timestep(0.06, substeps), substeps)
        arm.read(one_by_one.read(), 0)
        assert_same([at_once.drive(target, 0.06)], [one_by_one.read()])


def step_alone(arm: object, speeds: list[float], step: float, substeps: int) -> None:
    """Turn an arm, calling Bullet for each physics step."""
    client = {"physicsClientId": arm.client}
    pybullet.setPhysicsEngineParameter(fixedTimeStep=step, numSubSteps=0, **client)
    pybullet.setJointMotorControlArray(
        arm.body, arm.joints, pybullet.VELOCITY_CONTROL, targetVelocities=speeds, forces=arm.forces, **client
    )
    for _ in range(substeps):
        pybullet.stepSimulation(**client)


def test_ground_contact_is_that_of_the_geometry():
    """On 500 random poses there is contact exactly where a moving link's shape is below the ground."""
    poses = random_poses(500)
    heights = np.array([lowest_height(pose) for pose in poses])
    contact = np.array(placed_contacts(ROBOT, poses))
    clear = np.abs(heights) > 1e-3
    assert 50 < contact.sum() < 450
    np.testing.assert_array_equal(contact[clear], heights[clear] < 0.0)


def placed_contacts(robot: Robot, poses: np.ndarray) -> list[bool]:
    """Whether an arm touches the ground at each of the poses."""
    simulation = open_arms(1, robot)
    return [bool(simulation.place(pose[None]).ground_contact[0]) for pose in poses]


@pytest.mark.parametrize("height", [2e-4, -1e-3])
def test_ground_contact_is_exact(height: float):
    """An arm that is placed 0.2 mm above the ground does not touch it, also after it did; one 1 mm below does."""
    simulation, fallen = open_arms(1), [pose for pose in random_poses(200) if lowest_height(pose) < -0.05]
    assert len(fallen) > 30
    for pose in fallen:
        placed = pose_at_height(height, pose)
        for _ in range(2):
            assert simulation.place(placed[None]).ground_contact[0] == (height < 0.0)
            simulation.drive((placed + 0.02 * (pose - placed))[None], PERIOD)


# Bullet rounds edges: corners of boxes end up to 0.7 mm early.
def pose_at_height(height: float, fallen: np.ndarray) -> np.ndarray:
    """The pose between home and one below the ground whose lowest point is at a height [m], to a micrometre."""
    above, below = ROBOT.home, fallen
    while np.abs(above - below).max() > 1e-7:
        middle = (above + below) / 2.0
        above, below = (middle, below) if lowest_height(middle) > height else (above, middle)
    return above


def test_ground_contact_is_that_of_the_end_of_the_period():
    """Contact is told of the joint positions that are told with it, not of those of the physics step before."""
    states = wander(open_arms(1), 1, 600)
    told = np.array([state.ground_contact[0] for state in states])
    heights = np.array([lowest_height(state.qpos[0]) for state in states])
    clear = np.abs(heights) > 3e-3  # Bullet lets a loaded contact hover
    assert told.sum() > 5
    np.testing.assert_array_equal(told[clear], heights[clear] < 0.0)


def test_pressed_on_arm_touches_the_ground():
    """An arm that pushes against the ground touches it in every period, also while Bullet lets it hover."""
    simulation = open_arms(1)
    for share in np.linspace(0.0, 1.0, 20):
        simulation.drive(home(1) + share * (FALLEN - home(1)), PERIOD)
    assert all(simulation.drive(FALLEN, PERIOD).ground_contact[0] for _ in range(50))


def lowest_height(pose: np.ndarray) -> float:
    """Distance of the moving links from the ground [m], negative inside it, by another engine's geometry."""
    data = mujoco.MjData(BARE)
    data.qpos[:] = pose
    mujoco.mj_kinematics(BARE, data)
    ground = BARE.geom("ground").id
    moving = [geom for geom in range(BARE.ngeom) if BARE.body(BARE.geom_bodyid[geom]).name in MOVING_LINKS]
    return min(mujoco.mj_geomDistance(BARE, data, ground, geom, 3.0, None) for geom in moving)


def bare_model() -> mujoco.MjModel:
    """The arm on a plane, and nothing else."""
    spec = mujoco.MjSpec.from_string(ROBOT.urdf)
    spec.compiler.fusestatic = False
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1])
    return spec.compile()


BARE = bare_model()


@pytest.mark.parametrize("link", MOVING_LINKS)
def test_every_moving_link_touches_the_ground(link: str):
    """An arm of which only one link has a shape touches the ground with it."""
    assert any(placed_contacts(only_shape_of(link), random_poses(500)))


def test_base_does_not_touch_the_ground():
    """The base, which stands on the ground, is no contact."""
    assert not any(placed_contacts(only_shape_of("base_link"), random_poses(100)))


def test_what_is_fixed_to_the_base_does_not_touch_the_ground():
    """Where the URDF's root is a frame that carries the base, the base is no contact either."""
    tree = ElementTree.fromstring(only_shape_of("base_link").urdf)
    tree.insert(0, ElementTree.fromstring('<link name="world"/>'))
    mount = '<joint name="mount" type="fixed"><parent link="world"/><child link="base_link"/></joint>'
    tree.append(ElementTree.fromstring(mount))
    mounted = with_urdf(tree)
    assert not any(placed_contacts(mounted, random_poses(100)))


def only_shape_of(link: str) -> Robot:
    """The arm without the shapes of all links but one."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    for element in tree.findall("link"):
        for shape in [*element.findall("collision"), *element.findall("visual")]:
            if element.get("name") != link:
                element.remove(shape)
    return with_urdf(tree)


def with_urdf(tree: ElementTree.Element) -> Robot:
    """The arm with another URDF."""
    return replace(ROBOT, urdf=ElementTree.tostring(tree, encoding="unicode"))


def test_links_do_not_touch_one_another():
    """Folded into itself high above the ground, the arm touches nothing and is not pushed apart."""
    folded = np.radians([[0.0, -60.0, 80.0, 0.0, 135.0, 0.0]])
    assert lowest_height(folded[0]) > 0.1
    simulation = open_arms(1)
    assert not simulation.place(folded).ground_contact.any()
    assert np.degrees(np.abs(simulation.drive(folded, PERIOD).qpos - folded).max()) < 0.01


@pytest.mark.parametrize("start", [ROBOT.home[None], FALLEN])
def test_reset_in_the_middle_forgets_all(start: np.ndarray):
    """After moves, contacts and resets an arm goes on, bit for bit, as a new one: from home, and from in the ground."""
    used = open_arms(1)
    wander(used, 1, 300, seed=1)
    used.place(FALLEN)
    for _ in range(3):
        used.drive(FALLEN + 0.1, PERIOD)
    runs = []
    for simulation in (used, open_arms(1)):
        first = copied(simulation.reset(start, np.ones(1, bool)))
        held = [copied(simulation.drive(start, PERIOD)) for _ in range(5)]
        runs.append([first, *held, *wander(simulation, 1, 200)])
    assert_same(*runs)


def test_reset_of_one_arm_does_not_touch_the_others():
    """An arm beside one that is reset again and again moves, bit for bit, as one alone."""
    pair, alone = open_arms(2), open_arms(1)
    for period in range(40):
        target = home(1) + 0.3 * np.sin(0.1 * period)
        state = copied(pair.drive(np.repeat(target, 2, 0), PERIOD))
        assert_same([State._make(array[1:] for array in state)], [alone.drive(target, PERIOD)])
        pair.reset(np.repeat(FALLEN, 2, 0), np.array([True, False]))


def test_batch_moves_as_one_arm_alone():
    """Each arm of a batch moves, bit for bit, as one alone."""
    (alone, batch) = (wander(open_arms(num_envs), num_envs, 150, same=True) for num_envs in (1, 5))
    for env in range(5):
        assert_same(alone, [State._make(array[env : env + 1] for array in state) for state in batch])


def test_second_process_gives_the_same():
    """Another process gives the same states, bit for bit, contacts and resets in the middle included."""
    code = (
        "import hashlib, harness, numpy as np\n"
        "from harness_plugins.simulators.pybullet import PyBullet\n"
        "robot = harness.load_robot('fd100')\n"
        "arms, rng, digest = PyBullet().open(robot, 2, 0.1), np.random.default_rng(0), hashlib.sha256()\n"
        "contacts = 0\n"
        "for period in range(150):\n"
        "    if period % 50 == 0:\n"
        "        state = arms.reset(np.tile(robot.home, (2, 1)), np.array([True, period == 0]))\n"
        "    state = arms.drive(state.qpos + rng.uniform([-0.1, 0, -0.1, -0.1, -0.1, -0.1], 0.1, (2, 6)), 0.1)\n"
        "    contacts += state.ground_contact.sum()\n"
        "    [digest.update(array.tobytes()) for array in state]\n"
        "assert contacts > 5, contacts\n"
        "print(digest.hexdigest())"
    )
    first, second = (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    )
    assert first == second
    assert len(first) == 64 + len("\n")


def test_joints_are_in_the_order_of_the_robot():
    """Where each joint is told another angle, each has its own."""
    pose = np.radians([[-50.0, -30.0, 20.0, 70.0, 110.0, 200.0]])
    np.testing.assert_allclose(open_arms(1).place(pose).qpos, pose, atol=1e-12)


def test_order_of_the_elements_in_the_urdf_does_not_matter():
    """A URDF that lists its joints and links backwards is the same arm."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    tree[:] = tree[::-1]
    pose = random_poses(1)
    arms = [open_arms(1, robot) for robot in (ROBOT, with_urdf(tree))]
    first, second = (arm.place(pose) for arm in arms)
    np.testing.assert_allclose(first.qpos, second.qpos, atol=1e-12)
    np.testing.assert_allclose(first.end_effector, second.end_effector, atol=1e-12)


def test_end_effector_is_the_frame_of_its_link():
    """On 200 random poses the end effector is where the robot's kinematics put it, to single precision."""
    poses, simulation = random_poses(200), open_arms(1)
    told = np.array([simulation.place(pose[None]).end_effector[0].copy() for pose in poses])
    np.testing.assert_allclose(told, ROBOT.end_effector(poses), atol=3e-7)


def test_link_without_inertia_weighs_nothing():
    """A link to which the URDF gives no inertia is not given 1 kg by Bullet, and nothing is printed about it."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    for link in tree.findall("link[@name='tool0']"):
        for inertial in link.findall("inertial"):
            link.remove(inertial)
    plain = normal_urdf(parse_urdf(ElementTree.tostring(tree, "unicode")), ROBOT.joint_names, ROBOT.folder)
    simulation = open_arms(1, replace(ROBOT, urdf=plain.text))
    (arm,) = simulation.arms
    assert pybullet.getDynamicsInfo(arm.body, arm.tip, physicsClientId=arm.client)[0] < 1e-5


def test_mesh_is_found_from_the_folder_of_the_robot(tmp_path: Path):
    """A mesh whose path starts from the robot's folder reaches the ground."""
    (tmp_path / "long.obj").write_text("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 -3\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
    robot = with_mesh(tmp_path, "long.obj")
    plain = normal_urdf(parse_urdf(robot.urdf), robot.joint_names, tmp_path)
    assert open_arms(1, replace(robot, urdf=plain.text)).read().ground_contact.all()


def test_missing_mesh_is_a_usage_error(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """A mesh that is not there is a usage error that names the robot; what Bullet prints of it goes to stderr."""
    with pytest.raises(UsageError, match="cannot load the URDF of robot 'fd100'"):
        open_arms(1, with_mesh(tmp_path, "none.obj"))
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "none.obj" in printed.err


def with_mesh(folder: Path, filename: str) -> Robot:
    """The arm with a mesh as the only shape of its first moving link."""
    tree = ElementTree.fromstring(only_shape_of("none").urdf)
    shape = f'<collision><geometry><mesh filename="{filename}"/></geometry></collision>'
    tree.find("link[@name='link1']").append(ElementTree.fromstring(shape))
    return replace(with_urdf(tree), folder=folder)


@pytest.mark.parametrize("given", ["substeps=0", "substeps=1.5", "iterations=0", "gpu=1"])
def test_bad_setting_is_a_usage_error(given: str):
    """A setting that cannot be is refused, in one line that names it."""
    with pytest.raises(UsageError, match=given.partition("=")[0]):
        harness.make_env(f"pybullet:{given}")


def test_too_many_clients_are_a_usage_error(monkeypatch: pytest.MonkeyPatch):
    """Where Bullet opens no more clients, one line says what to do."""

    def refuse(_: int) -> int:
        raise pybullet.error("Exceeding maximum number of physics connections.")

    monkeypatch.setattr(pybullet, "connect", refuse)
    with pytest.raises(UsageError, match="take fewer envs"):
        open_arms(1)


@pytest.mark.parametrize("render", [False, True])
def test_close_gives_all_clients_back(render: bool):
    """After `close` no client is connected, that of the frames included; a second call does nothing."""
    simulation = open_arms(2)
    if render:
        simulation.render(0, np.zeros(3), 32, 24)
    clients = list(simulation._clients)
    assert len(clients) == 2 + render
    simulation.close()
    simulation.close()
    assert not any(pybullet.isConnected(physicsClientId=client) for client in clients)


def test_simulation_that_nothing_holds_is_closed():
    """Without `close`, the clients go with the simulation."""
    simulation = open_arms(1)
    (client,) = simulation._clients
    del simulation
    assert not pybullet.isConnected(physicsClientId=client)


def test_frame_shows_something():
    """A frame has the size asked for, a second one another, and neither is of one colour."""
    simulation = open_arms(1)
    for width, height in ((320, 240), (64, 48), (75, 33)):
        frame = simulation.render(0, np.array([0.6, 0.3, 0.6]), width, height)
        assert frame.shape == (height, width, 3)
        assert frame.dtype == np.uint8
        assert frame.std() > 10.0


def test_frame_shows_the_arm_and_the_target():
    """Another arm, another pose and another target give another frame; the same ones give the same."""
    simulation, poses = open_arms(2), np.stack([ROBOT.home, ROBOT.home + 0.5])
    near, far = np.array([0.6, 0.3, 0.6]), np.array([0.9, -0.4, 0.9])
    simulation.place(poses)
    frame = simulation.render(0, near, 320, 240)
    assert (simulation.render(0, near, 320, 240) == frame).all()
    assert (simulation.render(0, far, 320, 240) != frame).any()
    assert (simulation.render(1, near, 320, 240) != frame).any()
    simulation.place(poses[::-1])
    assert (simulation.render(1, near, 320, 240) == frame).all()


def test_frames_change_nothing():
    """An arm that is looked at moves, bit for bit, as one that is not."""
    seen, unseen = open_arms(1), open_arms(1)
    for period in range(20):
        target = home(1) + 0.3 * np.sin(0.3 * period)
        seen.render(0, target[0, :3], 32, 24)
        assert_same([seen.drive(target, PERIOD)], [unseen.drive(target, PERIOD)])
