"""An experiment as a user writes it, and the cells it expands to."""

import re
import shutil
from itertools import product

import pytest
import tomli_w

import harness_robots
from harness import load_registry
from harness.experiment.plan import check_experiment, expand, read_experiment
from harness.record.store import EXPERIMENT
from harness.registry import choose
from tests.refusals import refused
from tests.registered import FD100, REGISTRY, UNITY_ARM
from tests.stores import create_store

BASE = {"sim": ["ideal"], "algo": ["wander"], "reward": ["arp"]}


def _plan(registry, **keys):
    return expand(check_experiment({**BASE, **keys}), registry)


def _write(folder, keys):
    path = folder / "My_Experiment.toml"
    path.write_text(tomli_w.dumps(keys))
    return path


def test_defaults_compare_two_rewards_with_the_baseline(toys):
    """With a simulator and an algorithm alone: six seeds, 10,000 steps, 100 episodes of evaluation."""
    plan = expand(check_experiment({"sim": "ideal", "algo": "wander"}), toys)
    assert plan.baseline == "baseline"
    expected = [*product(range(6), ("baseline", "arp", "dense"))]
    assert [(cell.seed, cell.reward.label) for cell in plan.cells] == expected
    assert {(cell.steps, cell.evaluation_episodes, cell.task.label) for cell in plan.cells} == {
        (10_000, 100, "fd100-reach")
    }


def test_seeds_are_outermost(toys):
    """Every combination has a run early: a plan that is cut short still compares."""
    plan = _plan(toys, algo=["wander", "wander:width=8"], reward=["arp", "arp:k2=2"], seeds=2)
    expected = [*product((0, 1), ("wander", "wander:width=8"), ("baseline", "arp", "arp:k2=2"))]
    assert [(cell.seed, cell.algorithm.label, cell.reward.label) for cell in plan.cells] == expected


def test_epsilon_of_another_arm_stands_in_the_cell(toys):
    """As a number, so that what is planned later from the same file is the same; the FD100's cells keep their ids."""
    own, other = _plan(toys, seeds=1).cells[0], _plan(toys, seeds=1, robot="unity-arm").cells[0]
    assert (own.task.label, dict(own.task.params)["epsilon"]) == ("fd100-reach", 0.05)
    epsilon = dict(other.task.params)["epsilon"]
    assert other.task.label == f"fd100-reach:epsilon={epsilon}"
    assert epsilon == pytest.approx(0.05 * UNITY_ARM.reach / FD100.reach, rel=5e-3)
    assert _plan(toys, **{**_plan(toys, seeds=1, robot="unity-arm").resolved, "seeds": 1}).cells[0].id == other.id
    given = _plan(toys, seeds=1, robot="unity-arm", task="fd100-reach:epsilon=0.05").cells[0]
    assert (given.task.label, dict(given.task.params)["epsilon"]) == ("fd100-reach", 0.05)


@pytest.mark.parametrize(
    ("keys", "count"),
    [
        ({"reward": ["arp", "arp:k2=1.5", "arp:k1=1,k2=1.5", {"name": "arp", "k2": 1.5}]}, 2),
        ({"sim": ["ideal", "ideal"]}, 2),
        ({"task": ["fd100-reach", "fd100-reach"]}, 2),
        ({"algo": ["wander", "wander:width=4", {"name": "wander", "width": 4.0}]}, 2),
        ({"reward": ["arp", "baseline"]}, 3),
        ({"reward": ["arp", "arp:k2=2"]}, 3),
    ],
)
def test_what_is_named_twice_runs_once(toys, keys, count):
    """Choices are the same when their parameters are, however written; the baseline runs again as its own control."""
    plan = _plan(toys, seeds=[7, 7], **keys)
    assert len(plan.cells) == count
    assert len({cell.id for cell in plan.cells}) == count


@pytest.mark.parametrize(
    ("seeds", "listed"), [(1, [0]), (3, [0, 1, 2]), ([5], [5]), ([3, 1, 3], [3, 1]), ("2", [0, 1])]
)
def test_seeds_are_a_number_or_a_list(seeds, listed):
    """A number counts from 0; a list is taken as it stands, each once."""
    assert check_experiment({**BASE, "seeds": seeds}).seed_list == listed


def test_plan_of_the_same_cells_has_the_same_id(toys):
    """The id names what is run: another step is another plan."""
    assert _plan(toys).id == _plan(toys, reward=["arp:k2=1.5"]).id
    assert _plan(toys).id != _plan(toys, steps=10_001).id


@pytest.mark.parametrize(
    ("task", "form"),
    [
        ("fd100-reach", "fd100-reach:action=discrete:action=movej"),
        ("fd100-reach:action=movel", "fd100-reach:action=discrete:action=movel"),
        ("fd100-reach:epsilon=0.1", "fd100-reach:epsilon=0.1,action=discrete:action=movej"),
        (
            "fd100-reach:action=(movel:frame=tcs,tip_speed=0.3)",
            "fd100-reach:action=(discrete:action=movel:frame=tcs,tip_speed=0.3)",
        ),
        ("unity-reach", "unity-reach:action=discrete:action=set-joints"),
    ],
)
def test_discrete_algorithm_gets_the_discrete_form_of_a_task(toys, task, form):
    """Its choices are among what the task's own mode can do, and the cell's task says so."""
    plan = _plan(toys, algo=["buttons", "wander"], task=task, seeds=1)
    assert plan.skipped == ()
    labels = {(cell.algorithm.label, cell.task.label) for cell in plan.cells}
    assert labels == {("buttons", form), ("wander", choose(toys, "tasks", task).label)}


@pytest.mark.parametrize("task", ["fd100-reach", "fd100-reach:action=discrete"])
def test_algorithm_for_both_kinds_of_action_gets_the_task_as_it_is(toys, task):
    """Nothing has to be changed for it."""
    assert {cell.task.label for cell in _plan(toys, algo=["both"], task=task).cells} == {task}


def test_discrete_form_is_the_task_that_a_user_would_name(toys):
    """The cells are those of the discrete task itself."""
    named = _plan(toys, algo=["buttons"], task="fd100-reach:action=discrete:action=movej")
    assert _plan(toys, algo=["buttons"]).cells == named.cells


def test_continuous_algorithm_is_skipped_on_a_discrete_task(toys):
    """A combination that cannot work does not stop the others, and is never dropped silently."""
    plan = _plan(toys, algo=["buttons", "wander"], task="fd100-reach:action=discrete", seeds=1)
    assert {cell.algorithm.label for cell in plan.cells} == {"buttons"}
    assert [(cell.algorithm.label, reason) for cell, reason in plan.skipped] == 2 * [
        ("wander", "wander takes continuous actions, the task's are discrete")
    ]


def test_discrete_algorithm_is_skipped_on_a_task_without_a_choice_of_actions(toys):
    """A task that has no parameter `action` keeps its actions."""
    plan = _plan(toys, algo=["buttons", "wander"], task="handless", seeds=1)
    assert {cell.algorithm.label for cell in plan.cells} == {"wander"}
    assert {reason for _, reason in plan.skipped} == {
        "buttons takes discrete actions, the task's are continuous, and it has no parameter 'action' to choose others"
    }


def test_steps_that_do_not_fit_the_envs_are_skipped_with_the_reason(toys):
    """Ten steps on four envs would not be ten steps."""
    plan = _plan(toys, algo=["wander:num_envs=4", "wander:num_envs=5"], steps=10, seeds=1)
    assert {reason for _, reason in plan.skipped} == {
        "steps=10 is not a multiple of the 4 envs that wander:num_envs=4 trains on"
    }
    assert {cell.algorithm.label for cell in plan.cells} == {"wander:num_envs=5"}


def test_baseline_is_compared_with_itself_by_other_seeds(toys):
    """The null control A/A: as many trainings again, after all others, none with a seed of the experiment."""
    plan = _plan(toys, reward=["arp", "baseline"], seeds=[0, 3])
    assert plan.control == {0: 4, 3: 7}
    assert [(cell.seed, cell.reward.label) for cell in plan.cells] == [
        *((0, "baseline"), (0, "arp"), (3, "baseline"), (3, "arp")),
        *((4, "baseline"), (7, "baseline")),
    ]


@pytest.mark.parametrize(("reward", "seeds", "pairs"), [("baseline", [0, 1, 2, 3], {0: 2, 1: 3}), ("arp", [0, 1], {})])
def test_baseline_alone_has_its_control(toys, reward, seeds, pairs):
    """It need not stand beside another reward; where it was not asked for, no cell is trained for it."""
    plan = _plan(toys, reward=[reward], seeds=2)
    assert (sorted({cell.seed for cell in plan.cells}), plan.control) == (seeds, pairs)


def test_any_reward_may_be_the_baseline(toys):
    """The others are compared with the one that is named."""
    plan = _plan(toys, baseline="arp:k2=2", reward=["baseline", "arp:k2=2.0"], seeds=1)
    assert plan.baseline == "arp:k2=2"
    assert [cell.reward.label for cell in plan.cells] == ["arp:k2=2", "baseline", "arp:k2=2"]
    assert plan.control == {0: 1}


def test_unknown_names_are_refused(toys, subtests):
    """One line, before anything runs."""
    for keys, message in [
        ({"sim": ["idael"]}, "No simulator 'idael'. There is: dm_control, drake, ideal, "),
        ({"algo": ["wonder"]}, "No algorithm 'wonder'."),
        ({"reward": ["apr"]}, "No reward 'apr'."),
        ({"baseline": "bsaeline"}, "No reward 'bsaeline'."),
        ({"task": "reach"}, "No task 'reach'."),
        ({"robot": "fd10"}, "No robot 'fd10'."),
        ({"robot": "./nowhere"}, "No robot at './nowhere'"),
    ]:
        with subtests.test(keys=keys), refused(f"^{re.escape(message)}"):
            _plan(toys, **keys)


def test_missing_library_is_noticed_before_anything_runs(write_plugin):
    """The plan cannot be made, and the message names the extra."""
    source = (
        "import harness\n@harness.hookimpl\ndef register_simulators(register):\n"
        "    register('odd', 'a:B', summary='', requires=['no_such_engine'], extra='odd')\n"
    )
    registry = load_registry([write_plugin(source, "odd")])
    with refused(r"Simulator 'odd' needs no_such_engine: pip install '.*\[odd\]'"):
        _plan(registry, sim=["odd"])


REFUSED = [
    ({"seeds": 0}, "seeds=0: Input should be greater than 0"),
    ({"seeds": [0, -1]}, "seeds.1=-1: Input should be greater than or equal to 0"),
    ({"seeds": []}, "seeds=[]: "),
    ({"seeds": [0, True]}, "must be a number"),  # it would be seed 1
    ({"seeds": 1_000_000}, "seeds=1000000: Input should be less than or equal to 10000"),
    ({"seeds": 1e9}, "seeds=1000000000.0: Input should be less than or equal to 10000"),
    ({"seeds": list(range(10_001))}, "at most 10000 items"),
    ({"seeds": [2**31]}, "less than or equal to 2147483647"),
    ({"steps": 0}, "steps=0: Input should be greater than 0"),
    ({"steps": -5}, "steps=-5: Input should be greater than 0"),
    ({"steps": "many"}, "steps='many': Input should be a valid integer"),
    ({"steps": 1.5}, "steps=1.5: Input should be a valid integer"),
    ({"steps": 10**10}, "steps=10000000000: Input should be less than or equal to 1000000000"),
    ({"steps": 10**400}, "less than or equal to 1000000000"),
    ({"evaluate_every": -1}, "evaluate_every=-1: Input should be greater than or equal to 0"),
    ({"evaluate_every": 10**10}, "less than or equal to 1000000000"),
    ({"evaluation_episodes": 0}, "evaluation_episodes=0: Input should be greater than 0"),
    ({"evaluation_episodes": 10**6}, "less than or equal to 100000"),
    ({"robot": 3}, "robot=3: Input should be a valid string"),
    ({"reward": [3]}, "reward.0=3: Input should be a valid string"),
    ({"reward": [f"r{number}" for number in range(1_001)]}, "at most 1000 items"),
    ({"sim": "x" * 10_001}, "has 10,001 characters, 10,000 are allowed"),
    *(
        ({key: True}, f"{key}=True: must be a number")  # it would count as 1
        for key in ("seeds", "steps", "evaluation_episodes", "evaluate_every", "evaluation_horizon")
    ),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED, ids=[message for _, message in REFUSED])
def test_values_out_of_range_are_refused(keys, message):
    """The key, what was given, what is allowed; in a short line, before anything is made of it."""
    with refused(f"^(Experiment: |'x).*{re.escape(message)}") as told:
        check_experiment({**BASE, **keys})
    assert len(str(told.value)) < 300


def test_unknown_key_offers_the_nearest():
    """A slip in a file is named, with the keys there are."""
    with refused(r"has no parameter 'stesp'. There is: sim, algo, .*\. Did you mean 'steps'\?"):
        check_experiment({**BASE, "stesp": 3})


@pytest.mark.parametrize("key", ["sim", "algo"])
@pytest.mark.parametrize("value", [None, []])
def test_simulator_and_algorithm_have_to_be_named(key, value):
    """There is no default for what the experiment is about."""
    with refused(f"Experiment names no {key}: give --{key} NAME, or the key '{key}' in a file"):
        check_experiment({**BASE, key: value})


def test_experiment_is_read_from_a_file(toys, tmp_path):
    """Every key of the file is a field; a single name need not stand in a list, a table is a name with parameters."""
    keys = {"sim": "ideal", "algo": {"name": "wander", "width": 8}, "reward": ["arp:k2=2"], "seeds": [4], "steps": 20}
    plan = expand(read_experiment(_write(tmp_path, keys), {}), toys)
    assert plan.cells == _plan(toys, algo=["wander:width=8"], reward=["arp:k2=2"], seeds=[4], steps=20).cells


def test_flag_wins_over_a_key(tmp_path):
    """What the command line gives replaces what the file says; the rest stays."""
    path = _write(tmp_path, {**BASE, "steps": 20, "seeds": 2})
    experiment = read_experiment(path, {"steps": 40, "algo": ["buttons"]})
    assert (experiment.steps, experiment.algo, experiment.seeds) == (40, ["buttons"], 2)


def test_resolved_experiment_reads_back_to_the_same_cells(toys, tmp_path):
    """The experiment.toml that a run leaves, given to another run, is the same experiment, skipped cells included."""
    plan = _plan(
        toys,
        algo=["wander:width=8,note=a b", "wander", "buttons"],
        reward=["arp:k2=2.1", "arp"],
        task="fd100-reach:target_center=0.8x0x0.7,epsilon=0.1",
        seeds=[3, 1],
        steps=30,
    )
    again = expand(read_experiment(create_store(tmp_path / "out", plan).folder / EXPERIMENT, {}), toys)
    assert again == plan
    assert [cell.id for cell in again.cells] == [cell.id for cell in plan.cells]


def test_resolved_experiment_has_every_key(toys):
    """Defaults are filled in, parameters too: a later version with other defaults still reads the same."""
    resolved = _plan(toys).resolved
    keys = "sim algo reward baseline task robot seeds steps evaluation_episodes evaluate_every deterministic"
    assert set(resolved) == {*keys.split()}
    assert resolved["reward"] == [{"name": "arp", "k1": 1.0, "k2": 1.5}]
    assert resolved["seeds"] == list(range(6))
    assert resolved["task"]["horizon"] == 100


@pytest.mark.parametrize(
    ("content", "told"),
    [
        *((it, "cannot be read") for it in (b"steps = ", b"\xff\xfe", b"[sim", b"steps = 1\nsteps = 2", ...)),
        (None, ""),
    ],
    ids=repr,
)
def test_file_that_is_no_toml_is_refused(tmp_path, content, told):
    """Nor a folder, nor a file that is not there: the message names it, and is one line."""
    path = tmp_path / "bad.toml"
    if content is ...:
        path.mkdir()
    elif content is not None:
        path.write_bytes(content)
    with refused(rf"xperiment file '{path}'.*{told}"):
        read_experiment(path, {})


@pytest.mark.parametrize("keys", [{**BASE, "stpes": 3}, {**BASE, "steps": 0}, {"algo": ["wander"]}], ids=str)
def test_errors_in_a_file_name_the_file(tmp_path, keys):
    """Its path is repeated as it is written."""
    path = _write(tmp_path, keys)
    with refused("^" + re.escape(f"Experiment file '{path}'")):
        read_experiment(path, {})


def test_robot_is_given_by_its_full_path(toys, tmp_path, monkeypatch):
    """A URDF or folder means the same in a worker that works elsewhere; a link to a URDF stays where it is."""
    (tmp_path / "here").mkdir()
    shutil.copytree(harness_robots.UNITY_ARM, tmp_path / "arm")
    (tmp_path / "linked.urdf").symlink_to(tmp_path / "arm" / "unity_arm.urdf")
    monkeypatch.chdir(tmp_path / "here")
    for given, full in [
        ("unity-arm", "unity-arm"),
        ("../arm", str(tmp_path / "arm")),
        ("../arm/unity_arm.urdf", str(tmp_path / "arm" / "unity_arm.urdf")),
        ("../linked.urdf", str(tmp_path / "linked.urdf")),
        ("harness_robots:unity_arm/unity_arm.urdf", "harness_robots:unity_arm/unity_arm.urdf"),
    ]:
        assert _plan(toys, robot=given).cells[0].robot == full


def test_a_matrix_of_too_many_cells_is_refused_before_it_is_made(toys):
    """The product of what may be named is larger than what may be run."""
    rewards = [f"arp:k1={1 + number}" for number in range(10)]
    with refused(r"10000 seeds x 1 simulators x 1 algorithms x 11 rewards are 110,000 cells, 100,000"):
        _plan(toys, seeds=10_000, reward=rewards)


def test_names_that_are_too_many_together_are_refused_before_one_is_looked_up(toys, monkeypatch):
    """A thousand rewards in a thousand tasks would take minutes to find that out."""
    monkeypatch.setattr("harness.experiment.plan.plan_tasks", lambda *given: pytest.fail("they were looked up"))
    names = [f"x{number}" for number in range(400)]
    with refused(r"400 tasks x 1 simulators x 1 algorithms x 400 rewards x 1 seeds are 160,000"):
        _plan(toys, seeds=1, reward=names, task=names)


@pytest.mark.parametrize("robot", ["x" * 5_000 + ".urdf", "a\0b/c.urdf"])
def test_a_robot_that_no_path_can_be_is_refused(toys, robot):
    """Too long for the file system, or with a byte that ends names."""
    with refused("No robot at"):
        _plan(toys, robot=robot)


def test_drives_that_a_robot_does_not_describe_are_refused(tmp_path):
    """Before anything is written; a simulator with ideal drives takes the robot."""
    (tmp_path / "arm.urdf").write_text(FD100.urdf)
    keys = {"algo": ["random"], "robot": str(tmp_path / "arm.urdf")}
    assert _plan(REGISTRY, sim=["mujoco:drive=ideal"], **keys).cells
    with refused(r"'arm' has no drives to simulate: its robot.toml has no table \[servo\]"):
        _plan(REGISTRY, sim=["mujoco:drive=servo"], **keys)
