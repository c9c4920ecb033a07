"""The project's own arm as an environment: the same steps are paid and measured as in the arm's own run."""

import pickle
from contextlib import closing
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness import load_registry, load_results
from harness.env.vector_env import ReachVectorEnv
from harness.experiment.environments.paid_again import PayAgain
from harness.experiment.environments.plan import columns_of
from harness.experiment.plan import check_experiment, expand
from harness.record import TraceWriter, read_recording, read_trace
from harness.registry import Choice, build_defaults, choose, read_given
from harness.score.scorer import pay_log
from harness_plugins.audit.search.place import Place, world_at
from harness_plugins.audit.transitions.environment import audited
from tests.refusals import refused
from tests.registered import REGISTRY

NAMES = (*REGISTRY.names("rewards"), "arp:k2=3", "scaled:reward=arp,factor=2")
TASKS = ("fd100-reach:horizon=40", "arp-2021:horizon=60", "unity-reach", "fd100-pose", "noisy-reach", "cluttered-reach")
STEPS = 150
MEASURES = {"success": "success_rate", "final_distance": "", "closest_distance": "", "ground_hits": ""}
TERMS = '''
def slow(step):
    """An arm's reward, by its terms."""
    return {"reach": -step.distance, "speed": -0.01 * abs(step.qvel).sum(-1)}
'''


def _made(task):
    return gymnasium.make("harness/Reach-v0", simulator="kinematic", task=task)


def _act(env):
    """Take random steps, the same ones whoever looks on."""
    env.action_space.seed(3)
    env.reset(seed=5)
    for _ in range(STEPS):
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()


def _trace(path, env):
    """What the arm's own run records of these steps."""
    arm = env.unwrapped.vector_env
    world = ReachVectorEnv(
        choose(REGISTRY, "simulators", "kinematic").build(REGISTRY, "simulators"), arm.robot, arm.task, arm.reward,
        records=("qvel",),
    )  # fmt: skip
    sizes = arm.robot.dof, world.episodes.action.shape[1]
    with closing(world), TraceWriter(path, *sizes, extras=world.episodes.extras) as world.recorder:
        env.action_space.seed(3)
        world.reset(seed=5)
        for _ in range(STEPS):
            world.step(env.action_space.sample()[None])
    return read_trace(path).load()


def _by_decision(trace, values, period):
    """Sums of environment steps, those of one decision together; a decision ends early with its episode."""
    taken = trace["step"] > 0
    step = trace["step"][taken]
    return np.add.reduceat(values[taken], np.flatnonzero((step - 1) % period == 0))


@pytest.mark.parametrize("task", TASKS)
def test_every_reward_of_the_arm_pays_as_in_its_own_run(task, tmp_path):
    """To rounding: the trace pays its rows by `pay_log`, and its own columns say what the task paid beside."""
    env = _made(task)
    trace, period = _trace(tmp_path / "trace.parquet", env), env.unwrapped.vector_env.task.decision_period
    rewards = {"own": "own", **dict(zip(NAMES, NAMES, strict=True))}
    with harness.RecordRewards(env, tmp_path / "live", trained_with="own", rewards=rewards) as env:
        _act(env)
    live = read_recording(tmp_path / "live").load()
    beside = sum(trace[name] for name in ("reward_ground", "reward_target", "reward_step"))
    assert_allclose(live["reward/own"], live["reward/baseline"], rtol=1e-12, atol=1e-12)
    for name in NAMES:
        paid = pay_log(choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards"), trace).total
        assert_allclose(live[f"reward/{name}"], _by_decision(trace, paid + beside, period), rtol=1e-12, atol=1e-12)


def test_it_is_measured_as_in_its_own_run(tmp_path):
    """The means over finished episodes of what the last step tells are the arm's own metrics."""
    env = _made(TASKS[0])
    trace = _trace(tmp_path / "trace.parquet", env)
    env = _made(TASKS[0])
    environment = choose(REGISTRY, "environments", "harness/Reach-v0").build(REGISTRY, "environments")
    told = columns_of(environment, env, REGISTRY)
    with harness.RecordRewards(env, tmp_path / "live", trained_with="own", **vars(told)) as env:
        _act(env)
    live = read_recording(tmp_path / "live").load()
    metrics = build_defaults(REGISTRY, "metrics", [it or name for name, it in MEASURES.items()])
    ends = live["terminated"] | live["truncated"]
    found = [live[f"behaviour/{name}"][ends].mean() for name in MEASURES]
    assert_allclose(found, [metric(trace) for metric in metrics.values()], rtol=1e-12)
    assert told.lower_is_better == {*MEASURES} - {"success"}


def test_a_recording_is_paid_again_by_a_reward_of_the_arm(tmp_path):
    """As it would have been while it was made, to the last bit."""
    own = {"trained_with": "own", "rewards": {"own": "own"}}
    with harness.RecordRewards(_made(TASKS[0]), tmp_path / "runs" / "one", **own) as env:
        _act(env)
    asked = {"own": "own", "arp:k2=3": "arp:k2=3"}
    with harness.RecordRewards(_made(TASKS[0]), tmp_path / "live", trained_with="own", rewards=asked) as env:
        _act(env)
    (paid,) = PayAgain(REGISTRY, ["arp:k2=3.0"]).run(tmp_path / "runs")
    assert (paid.names, paid.failed, paid.refused) == (("arp:k2=3",), (), "")
    name = "reward/arp:k2=3"
    scored, live = (read_recording(path).load()[name] for path in (paid.folder, tmp_path / "live"))
    assert_array_equal(scored, live)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """An experiment by what the env pays, by an arm's reward, one with a parameter, and a function of an arm's step."""
    folder = tmp_path_factory.mktemp("arm")
    (folder / "slow.py").write_text(TERMS)
    asked = {"task": "harness/Reach-v0:made_with=simulator=kinematic", "algo": "random", "seeds": 1, "steps": 60}
    rewards = ["arp:k2=3", "slow:speed=5", "sparse"]
    harness.run(
        **asked, baseline="arp", reward=rewards, evaluation_episodes=2, jobs=1, out=folder / "out",
        plugins=[folder / "slow.py"],
    )  # fmt: skip
    return load_results(folder / "out", plugins=[folder / "slow.py"])


def test_every_training_records_every_reward_that_is_compared(results):
    """By its label; an arm's function of a step with its terms, and what the task pays."""
    assert [cell.reward.label for cell in results.done_cells] == ["arp", "arp:k2=3", "slow:speed=5", "sparse"]
    for cell in results.done_cells:
        rewards = read_recording(results.store.cell_folder(cell) / "training").rewards
        assert {"own", "arp", "arp:k2=3", "slow", "sparse"} <= {*rewards}
        assert {"slow/reach", "slow/speed", "slow/task"} <= {
            it.removeprefix("reward/") for it in read_recording(results.store.cell_folder(cell) / "training").names
        }


def test_a_learner_is_paid_the_reward_that_it_is_trained_with(results):
    """The arm's, the task's own pay included."""
    cell = next(it for it in results.done_cells if it.reward.label == "sparse")
    live = read_recording(results.store.cell_folder(cell) / "training").load()
    assert live.facts.trained_with == "sparse"
    assert {*live["reward/sparse"]} <= {-0.0001, -1.0001, 0.9999}


def test_what_is_compared_changes_no_id():
    """A cell is the same whichever rewards it records beside its own."""
    asked = {"task": "harness/Reach-v0:made_with=simulator=kinematic", "algo": "random", "seeds": 1, "steps": 60}
    one, more = (expand(check_experiment({**asked, "reward": names}), REGISTRY) for names in ("arp", "arp,dense"))
    assert [cell.id for cell in more.cells][:2] == [cell.id for cell in one.cells]
    assert more.cells[0].records == ("arp", "dense")


def test_every_door_pays_alike(tmp_path):
    """The recorder, an experiment, an audit and a search give one reward one meaning: here its pay of random steps."""
    chosen = choose(REGISTRY, "rewards", "aarp")
    task = choose(REGISTRY, "environments", f"harness/Reach-v0:made_with=simulator=kinematic+task={TASKS[0]}")
    environment = task.build(REGISTRY, "environments")
    with closing(environment.make()) as env:
        given = columns_of(environment, env, REGISTRY, [chosen]).rewards["aarp"]
        asked = {"own": "own", "name": "aarp", "object": chosen.build(REGISTRY, "rewards"), "door": given}
        with harness.RecordRewards(env, tmp_path / "live", trained_with="own", rewards=asked) as recorded:
            _act(recorded)
    live = read_recording(tmp_path / "live").load()
    for name in ("object", "door"):
        assert_array_equal(live[f"reward/{name}"], live["reward/name"])
    place = Place(task, chosen)
    with closing(world_at(place, REGISTRY)) as world:
        world.space.seed(3)
        shown = world.show(5, np.array([world.space.sample() for _ in range(40)]))
    assert_array_equal(shown.paid, live["reward/name"][: len(shown.paid)])
    asked = {"registry": REGISTRY, "named": task.label, "rewards": ["aarp", "arp:k2=3"], "gamma": 0.9, "episodes": 1}
    (audit,), _ = audited(SimpleNamespace(**asked, against=None, success=""))
    assert audit.rewards == ("own", "aarp", "arp:k2=3")


def test_a_measure_that_needs_the_path_is_refused():
    """With where it is measured."""
    asked = {"task": "harness/Reach-v0:made_with=simulator=kinematic", "algo": "random", "steps": 60}
    with refused(r"No measure 'spl'.*needs the whole path.*--task fd100-reach --sim NAME"):
        expand(check_experiment({**asked, "measure": ["spl"]}), REGISTRY)


def test_other_environments_have_no_rewards_of_an_arm():
    """Their steps tell no distance."""
    with refused("gymnasium:id=Pendulum-v1: No reward 'arp'. There is: own"):
        expand(check_experiment({"task": "Pendulum-v1", "algo": "random", "steps": 60, "reward": "arp"}), REGISTRY)


def test_what_the_env_tells_can_be_sent(tmp_path):
    """To the process of a batch, or into a file."""
    env = _made(TASKS[0])
    env.reset(seed=0)
    told = env.step(env.action_space.sample())[4]["arm"]
    again = pickle.loads(pickle.dumps(told))
    assert again._fields == told._fields
    assert_array_equal(again.before.qpos, told.before.qpos)
    env.close()


def test_an_id_is_a_name_of_an_environment():
    """The same as with the name of the environment that makes it, parameters too."""
    short = choose(REGISTRY, "environments", "CartPole-v1:tells=angle")
    assert short == choose(REGISTRY, "environments", "gymnasium:id=CartPole-v1,tells=angle")
    assert choose(REGISTRY, "environments", {"name": "CartPole-v1"}).label == "gymnasium:id=CartPole-v1"
    assert REGISTRY.kinds_of("CartPole-v1") == ["environments"]


def test_a_name_that_is_taken_is_no_id(tmp_path):
    """A task of that name stays one, and so does an environment."""
    gymnasium.register("taken-v1", entry_point="gymnasium.envs.classic_control:PendulumEnv")
    text = """
import harness
@harness.hookimpl
def register_environments(register):
    register("taken-v1", "harness_plugins.environments.fetch_reach:FetchReach", summary="another")
"""
    (tmp_path / "taken.py").write_text(text)
    registry = load_registry(given=read_given([tmp_path / "taken.py"]))
    try:
        assert registry.get("environments", "taken-v1").target.endswith("FetchReach")
        assert choose(REGISTRY, "environments", "taken-v1") == Choice.from_json(
            choose(REGISTRY, "environments", "gymnasium:id=taken-v1").to_json()
        )
    finally:
        del gymnasium.registry["taken-v1"]


def test_a_file_of_the_current_folder_is_told_how_to_be_named(tmp_path, monkeypatch):
    """Gymnasium imports what stands before the colon, which this folder is not searched for."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_env.py").write_text("")
    told = "For my_env.py of this folder type PYTHONPATH=. before harness, and --task gymnasium:id=my_env:ID"
    for task in ("my_env", "my_env.py"):
        with refused(told):
            expand(check_experiment({"task": task, "algo": "random", "sim": "kinematic"}), REGISTRY)
    named = choose(REGISTRY, "environments", "gymnasium:id=Pendulum-v1").build(REGISTRY, "environments")
    assert told in named.near("my_env:Mine-v0")
    assert named.near("9" * 5_000) == ""  # no file has so long a name


def test_an_unknown_id_is_answered_with_the_nearest():
    """Among the names of tasks and environments, and as a parameter."""
    with refused(r"'Pendlum-v1'.*Ids of Gymnasium: Pendulum-v1, .*"):
        choose(REGISTRY, "environments", "gymnasium:id=Pendlum-v1").build(REGISTRY, "environments").make()
    with refused(r"No task 'Pendlum-v1'.*Ids of Gymnasium: Pendulum-v1, .*"):
        expand(check_experiment({"task": "Pendlum-v1", "algo": "random", "sim": "kinematic"}), REGISTRY)
