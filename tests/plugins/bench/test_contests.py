"""The contenders of an entry, and how they take turns."""

from contextlib import ExitStack
from types import SimpleNamespace
from unittest import mock

import numpy as np
import psutil
import pytest

import harness
from harness.authoring.checking import closed_motion
from harness.env.make import ReachEnv
from harness.errors import UsageError
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.bench.contests import (
    ENGINE,
    ENV,
    FEWEST,
    LIBRARY,
    MOST,
    SIMULATOR,
    Contender,
    Entry,
    Setting,
    open_contest,
    periods_of,
    require_memory,
    round_of,
    take_turns,
)
from harness_plugins.bench.stopwatch import Meter
from harness_plugins.kit import IdealSimulator


class Work:
    """A clock, and work that takes what is said."""

    def __init__(self) -> None:
        self.now, self.order = 0.0, []

    def clock(self) -> float:
        """Seconds since the beginning."""
        return self.now

    def of(self, name: str, *seconds: float):
        """Work that takes so long, one time after the other, the last one for ever."""
        left = list(seconds)

        def run() -> None:
            self.order.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]

        return run


def test_they_take_turns():
    """A slow moment meets both; the first time of each warms up."""
    work = Work()
    contenders = {name: Contender(work.of(name, 1.0), 1) for name in "ab"}
    take_turns(contenders, budget=12.0, clock=work.clock)
    assert work.order == ["a", "b"] * (1 + 6)


def test_what_counts_is_an_environment_step_and_no_warm_up():
    """A turn of 10 steps that takes 2 s is 0.2 s a step; the first one took 50."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 50.0, 2.0), 10)}, budget=1.0, clock=work.clock)
    assert found == {"a": [pytest.approx(0.2)] * FEWEST}


@pytest.mark.parametrize(("budget", "turns"), [(0.0, FEWEST), (10.0, 10), (1e9, MOST)])
def test_the_budget_says_how_many_turns(budget: float, turns: int):
    """Never fewer than can be told apart, never without an end."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 1.0), 1)}, budget, clock=work.clock)
    assert len(found["a"]) == turns


def test_work_that_is_short_is_repeated_within_a_turn():
    """5 ms of work are done four times, and a step still takes 5 ms."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 0.005), 1)}, budget=0.0, clock=work.clock)
    assert len(work.order) == 1 + 4 * FEWEST
    assert found["a"] == [pytest.approx(0.005)] * FEWEST


def test_preparation_does_not_count():
    """It is done before each turn."""
    work = Work()
    found = take_turns(
        {"a": Contender(work.of("a", 1.0), 1, prepare=work.of("prepare", 7.0))}, budget=0.0, clock=work.clock
    )
    assert found["a"] == [pytest.approx(1.0)] * FEWEST
    assert work.order == ["prepare", "a"] * (1 + FEWEST)


def test_a_part_of_the_work_can_be_what_counts():
    """What its meter saw in that turn, per step, and nothing of the rest."""
    work, meter = Work(), Meter()
    meter.clock = work.clock
    inner, outer = meter.timed(work.of("inner", 1.0)), work.of("outer", 3.0)

    def run() -> None:
        inner()
        outer()

    found = take_turns({"simulator": Contender(run, 2, part=meter)}, budget=0.0, clock=work.clock)
    assert found == {"simulator": [pytest.approx(0.5)] * FEWEST}


def test_a_speed_is_the_median_of_what_stood_beside_one_another():
    """The slow turn met both; the ratio of the medians would be 1."""
    told = round_of({"bare": [1.0, 1.0, 8.0], "ours": [2.0, 2.0, 16.0]}, "bare")
    assert told.speeds == {"ours": pytest.approx(0.5)}
    assert told.seconds == {"bare": 1.0, "ours": 2.0}


def test_without_a_reference_there_are_seconds_alone():
    """An algorithm that names no bare library."""
    told = round_of({"ours": [2.0, 3.0, 4.0]}, "")
    assert (told.seconds, told.speeds) == ({"ours": 3.0}, {})


SIMULATORS = ("kinematic", "mujoco", "dm_control", "pybullet")
ROBOT = harness.load_robot("fd100")
PERIOD = 0.1


def _simulator(name: str):
    registry = load_registry()
    return choose(registry, "simulators", name).build(registry, "simulators")


@pytest.mark.parametrize("num_envs", [1, 3])
@pytest.mark.parametrize("name", SIMULATORS)
def test_every_simulator_stands_beside_its_bare_engine(name: str, num_envs: int):
    """As many environment steps of all; the simulator's are those of the env."""
    with ExitStack() as stack:
        entry = Entry("simulators", "simulators", name, num_envs)
        contenders, reference = open_contest(entry, Setting(), load_registry(), stack)
        assert (list(contenders), reference) == ([ENGINE, SIMULATOR, ENV], ENGINE)
        assert {contender.steps for contender in contenders.values()} == {periods_of(num_envs) * num_envs}
        for contender in 2 * list(contenders.values()):  # episodes go on
            contender.prepare()
            contender.run()
        assert contenders[SIMULATOR].part.calls >= 2 * periods_of(num_envs)


def test_no_clock_is_asked_within_a_step_of_the_env():
    """The simulator has turns of its own: asking what time it is takes time."""
    with ExitStack() as stack:
        entry = Entry("simulators", "simulators", "kinematic")
        contenders, _ = open_contest(entry, Setting(), load_registry(), stack)
        for name in (SIMULATOR, ENV):
            contenders[name].prepare()
            before = contenders[SIMULATOR].part.calls
            contenders[name].run()
            assert (contenders[SIMULATOR].part.calls > before) == (name == SIMULATOR)


def test_engine_simulator_and_env_are_all_timed():
    """The clock told something of each, in every turn."""
    with ExitStack() as stack:
        contest = open_contest(Entry("simulators", "simulators", "kinematic"), Setting(), load_registry(), stack)
        found = take_turns(contest.contenders, budget=0.0)
    assert list(found) == [ENGINE, SIMULATOR, ENV]
    assert min(map(min, found.values())) > 0.0


@pytest.mark.parametrize("name", ["mujoco", "mujoco:substeps=7"])
def test_bare_mujoco_goes_where_the_simulator_goes(name: str, monkeypatch):
    """Along the same targets, one arm and many: no easier work is timed."""
    import mujoco

    made = []
    new = mujoco.MjData
    monkeypatch.setattr(mujoco, "MjData", lambda model: made.append(new(model)) or made[-1])
    targets = closed_motion(ROBOT, 1, 8)
    _simulator(name).bare_loop(ROBOT, targets, PERIOD)()
    np.testing.assert_allclose(made[-1].qpos, _driven(name, targets)[0], atol=2e-3)  # half a physics step apart
    assert made[-1].time == pytest.approx(8 * PERIOD)


def test_bare_rollout_takes_every_arm_through_every_physics_step(monkeypatch):
    """Whose states go in as they came out."""
    from mujoco import rollout

    made = []

    class Watched(rollout.Rollout):
        def rollout(self, model, data, initial_state, control, nstep, **others):
            out = super().rollout(model, data, initial_state, control, nstep=nstep, **others)
            made.append((initial_state.copy(), out[0][:, -1]))
            return out

    monkeypatch.setattr(rollout, "Rollout", Watched)
    targets = closed_motion(ROBOT, 3, 4)
    _simulator("mujoco").bare_loop(ROBOT, targets, PERIOD)()
    np.testing.assert_array_equal(made[1][0], made[0][1])
    np.testing.assert_allclose(made[-1][1][:, 0], 4 * PERIOD)
    np.testing.assert_allclose(made[-1][1][:, 1:7], _driven("mujoco", targets), atol=2e-3)


def test_bare_dm_control_goes_where_the_simulator_goes(monkeypatch):
    """One Physics per arm."""
    from harness_plugins.simulators import dm_control

    made = []
    new = dm_control.engine.Physics.from_model
    monkeypatch.setattr(dm_control.engine.Physics, "from_model", lambda model: made.append(new(model)) or made[-1])
    targets = closed_motion(ROBOT, 2, 8)
    _simulator("dm_control").bare_loop(ROBOT, targets, PERIOD)()
    found = np.array([physics.position() for physics in made])
    monkeypatch.undo()
    np.testing.assert_allclose(found, _driven("dm_control", targets), atol=2e-3)


def test_bare_bullet_goes_where_the_simulator_goes(monkeypatch):
    """One client per arm, each stepped once per period."""
    import pybullet

    from harness_plugins.simulators import pybullet as plugin

    calls, made, new = [], [], plugin.PyBullet.open
    step = pybullet.stepSimulation
    monkeypatch.setattr(pybullet, "stepSimulation", lambda **client: calls.append(client) or step(**client))
    monkeypatch.setattr(plugin.PyBullet, "open", lambda *given: made.append(new(*given)) or made[-1])
    targets = closed_motion(ROBOT, 2, 8)
    _simulator("pybullet").bare_loop(ROBOT, targets, PERIOD)()
    assert len(calls) == 16
    joints = [
        [state[0] for state in pybullet.getJointStates(arm.body, arm.joints, physicsClientId=arm.client)]
        for arm in made[0].arms
    ]
    monkeypatch.undo()
    np.testing.assert_allclose(joints, _driven("pybullet", targets), atol=2e-3)  # its motors are not exact


def _driven(name: str, targets: np.ndarray) -> np.ndarray:
    """Where the simulator itself is after the same motion, (num_envs, dof)."""
    simulation = _simulator(name).open(ROBOT, targets.shape[1], PERIOD)
    simulation.reset(targets[-1], np.ones(targets.shape[1], bool))
    for target in targets:
        simulation.drive(target, PERIOD)
    qpos = simulation.read().qpos.copy()
    simulation.close()
    return qpos


def test_a_batch_that_does_not_fit_into_memory_is_refused(monkeypatch):
    """Before it is opened, with what it takes and what is free."""

    class Large(IdealSimulator):
        def open(self, robot, num_envs, control_period):
            opened.append(num_envs)
            return super().open(robot, num_envs, control_period)

    opened, resident = [], iter([0, 16 * 2**30])
    process = SimpleNamespace(memory_info=lambda: SimpleNamespace(rss=next(resident)))
    monkeypatch.setattr(psutil, "Process", lambda: process)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=10 * 2**30))
    with pytest.raises(UsageError, match=r"1,024 envs, .* take about 2048 GiB of memory; 8 GiB may be used"):
        require_memory(Large(), ROBOT, 1024, PERIOD)
    assert opened == [16]


@pytest.mark.usefixtures("toys")
def test_an_algorithm_that_names_no_library_has_no_reference():
    """It is timed by itself."""
    with ExitStack() as stack:
        entry = Entry("algorithms", "algorithms", "sweep")
        contenders, reference = open_contest(entry, Setting(steps=8), load_registry(), stack)
        contenders["sweep"].prepare()
        contenders["sweep"].run()
    assert (list(contenders), reference) == (["sweep"], "")


@pytest.mark.parametrize("name", ["ppo:rollout=8,batch_size=8", "dqn:learning_starts=2"])
def test_a_training_stands_beside_one_by_the_bare_library(name: str):
    """Of as many steps; one whose actions are choices gets a task with choices."""
    with ExitStack() as stack:
        label = Entry("algorithms", "algorithms", name)
        contenders, reference = open_contest(label, Setting(steps=8), load_registry(), stack)
        assert (list(contenders), reference) == ([LIBRARY, name], LIBRARY)
        for contender in contenders.values():
            assert contender.steps == 8
            contender.prepare()
            contender.run()


def test_the_bare_library_trains_on_as_many_envs():
    """Anything else would be another work."""
    made = []
    with ExitStack() as stack, mock.patch.object(Ppo, "bare_training", lambda self, env, steps, seed: made.append(env)):
        open_contest(Entry("algorithms", "algorithms", "ppo:num_envs=4"), Setting(steps=8), load_registry(), stack)
    assert [len(envs) for envs in made] == [4]


def test_a_peer_steps_as_its_authors_ship_it(monkeypatch):
    """Random actions; a new episode where one ends; beside one env of ours and a batch."""
    peer = ReachEnv("kinematic", "fd100-reach:horizon=5")
    resets = []
    monkeypatch.setattr(peer, "reset", lambda **given: resets.append(given) or type(peer).reset(peer, **given))
    monkeypatch.setattr("harness_plugins.simulators.mujoco.panda_reach", lambda: peer)
    with ExitStack() as stack:
        entry = Entry("peers", "simulators", "mujoco", peer="PandaReach")
        contenders, reference = open_contest(entry, Setting(), load_registry(), stack)
        assert (list(contenders), reference) == (["PandaReach", "1 env", "64 envs"], "PandaReach")
        contenders["PandaReach"].prepare()
        contenders["PandaReach"].run()
    assert len(resets) >= 1 + contenders["PandaReach"].steps // 5
