"""`harness audit`: what one types and sees."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from harness import load_results
from tests.results.recordings.conftest import record

FEW = ("--episodes", 6, "--budget", 0)


def test_noise_on_actions_tells_a_knifes_edge(harness):
    """Creeping earns many times what finishing does, and less than that where actions are disturbed."""
    data = harness("audit --reward baseline --json", *FEW).json
    assert data["verdict"][1].startswith("FRAGILE: with action noise 0.05, as while it explores, ")
    still, noisy = ({row["policy"]: row["total"] for row in data[key]} for key in ("policies", "disturbed_policies"))
    assert still["creep"] > 10.0 * still["finish"]
    assert noisy["creep"] < 0.2 * still["creep"]
    assert noisy["finish"] == pytest.approx(still["finish"], rel=0.1)


def test_an_arm_is_searched_beside_its_scripts(harness):
    """The search begins from them: what creeping earns is found at once; and it is tried in another simulator."""
    (found,) = harness("audit --reward baseline --json --episodes 2 --budget 5000 --starts 1").json["cheats"]
    assert found["answer"] == "PAYS FOR FAILING"
    assert (found["success_told_by"], len(found["starts"]), len(found["elsewhere"])) == ("success", 1, 1)
    assert found["lines"][0].startswith("Failing earns ")


def test_a_task_that_scripts_cannot_do_is_searched_without_them(harness):
    """They move joints, and these actions move the tip."""
    answer = harness("audit --task fd100-reach:action=movel --reward dense --budget 500 --starts 1")
    assert answer.status == 0
    assert "What a cheat would do for dense" in answer.out
    assert "Not asked of scripts: The scripted policies of an audit move joints" in answer.out


def test_an_environment_is_searched_for_each_reward_that_is_named(harness, hover):
    """By a measure with a threshold that is named; the answer's word stands first in its line."""
    Path("behaviour.py").write_text("def place(step):\n    return step.observation[..., 0]\n")
    call = ("gymnasium:id=CartPole-v1", "--reward", "own,hover", *IN_PENDULUM[:-1], 3_000, "--starts", 1)
    out = harness("audit", *call, "--plugin", "behaviour.py", "--success", "place>-9").out
    assert out.count("\nNOTHING FOUND. The best-paid success earns ") == 2
    assert out.index("What a cheat would do for own") < out.index("What a cheat would do for hover")
    refused = harness("audit", *call, "--success", "plaice>-9")
    assert (refused.status, refused.out) == (2, "")
    assert "No measure 'plaice'" in refused.err


def test_measures_come_from_a_file_of_any_name(harness, hover):
    """`--measure` takes it as a run does, and a name as what tells success; two of those are refused."""
    Path("mine.py").write_text("def right(step):\n    return float(step.observation[..., 0] > 0)\n")
    call = ("gymnasium:id=CartPole-v1", "--reward", "own", "--episodes", 1, "--budget", 1_000, "--starts", 1)
    out = harness("audit", *call, "--measure", "mine.py", "--measure", "right", "--json").out
    assert json.loads(out)["cheats"][0]["success_told_by"] == "right"
    refused = harness("audit", *call, "--measure", "mine.py,right", "--success", "right>0.5")
    assert (refused.status, refused.err.count("\n")) == (2, 1)
    assert "'right>0.5' and 'right' cannot both tell success" in refused.err


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ("", {"against": "baseline", "task": "fd100-reach", "robot": "fd100", "episodes": 6}),
        ("--sim mujoco", {"simulator": "mujoco"}),
        (
            "--sim ideal --gamma 0.9 --task fd100-reach:horizon=30",
            {"simulator": "ideal", "gamma": 0.9, "task": "fd100-reach:horizon=30"},
        ),
    ],
)
def test_json_is_one_object(harness, flags, told):
    """What was asked, and the answer: not finishing pays more, in an engine too, where nothing holds quite still."""
    data = harness(f"audit --reward baseline --json {flags}", *FEW).json
    assert {key: data[key] for key in told} == told
    assert (data["reward"], data["best"], data["distance"]["value"]) == ("baseline", "creep", 0.0)
    assert data["verdict"][0].startswith("Not finishing pays more")
    assert {row["gamma"] for row in data["not_finishing_pays"]} == {1.0, data["gamma"]}
    assert ({row["policy"]: row["steps"] for row in data["policies"]}["hover"] == 30.0) == ("horizon=30" in flags)


GENTLE = """
def gentle(step):
    return {"reach": -step.distance, "effort": -0.01 * (step.action**2).sum(-1), "dock": 0.0 * step.distance}
"""


@pytest.fixture
def gentle(tmp_path):
    """The file of a reward with terms that reads the action."""
    (tmp_path / "gentle.py").write_text(GENTLE)
    return ("--plugin", "gentle.py", *FEW)


def test_a_function_of_steps_is_audited_by_term(harness, gentle):
    """What each term paid, what never paid, and what cannot be asked."""
    answer = harness("audit --reward gentle", *gentle)
    assert answer.status == 0
    out = " ".join(answer.out.split())
    assert "What each term paid in an episode" in out
    assert "The term 'dock' never paid in " in out
    assert "it reads action, which made-up distances do not have" in out


def test_weights_of_terms_can_be_given(harness, gentle):
    """Five times the weight, five times the pay of the term."""
    answer = harness("audit --reward gentle,gentle:effort=5 --json", *gentle)
    one, five = ({row["policy"]: row["terms"] for row in data["policies"]} for data in answer.json)
    assert five["random"]["effort"] == pytest.approx(5.0 * one["random"]["effort"])
    assert five["random"]["reach"] == one["random"]["reach"]


def test_several_rewards_have_a_table_each(harness, gentle):
    """In the order in which they were given, each against the same one."""
    out = harness("audit --reward dense,gentle --against arp", *gentle).out
    assert out.startswith("dense\n")
    assert "\n\ngentle\n" in out
    assert "\narp and dense\n" in out
    assert "\narp and gentle\n" in out


@pytest.mark.parametrize(
    ("returned", "status", "text"),
    [
        ("step.joint_speed", 2, "Reward 'bad': A step has no 'joint_speed'. It has: begin_distance"),
        ("-step.distance if step.step[0] < 9 else step.joint_speed", 2, "Reward 'bad': A step has no 'joint_speed'"),
        ("{'a' if step.step[0] < 3 else 'b': step.distance}", 2, "Reward 'bad': It paid the terms a at first, and now"),
        ("(step.distance, {'a': step.distance, 'b': step.distance})", 2, "is not the sum of its terms"),
        ("step.distance / (step.step != 4.0)", 1, "inf, no number within 1e+150, at step 4"),
        ("step.distance if step.step[0] < 9 else step[0][99]", 1, "raised IndexError"),
    ],
)
def test_a_reward_that_fails_says_where(harness, tmp_path, returned, status, text):
    """One line that names the reward, what it asked for and what there is."""
    (tmp_path / "bad.py").write_text(f"def bad(step):\n    return {returned}\n")
    answer = harness("audit --reward bad --plugin bad.py", *FEW)
    assert (answer.status, answer.out) == (status, "")
    assert text in answer.err


def test_the_command_loads_no_engine():
    """Without --sim neither an engine nor torch is imported."""
    code = (
        "import sys; from harness.cli.app import _run;"
        "_run(['audit', '--reward', 'baseline', '--episodes', '2', '--budget', '0']);"
        "assert not {'mujoco', 'pybullet', 'torch', 'stable_baselines3'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.fixture
def recordings(tmp_path):
    """Three trainings of two rewards, and random actions."""
    pays = {"plain": lambda a: a, "square": lambda a: (a - 0.5) ** 2}
    for seed in range(3):
        record(tmp_path / f"runs/{seed}", "plain", seed, [0.1 + 0.01 * seed, 0.5, 0.9], pays=pays)
    record(tmp_path / "random", "plain", 0, [0.2, 0.3], pays=pays, evaluation=True)
    return tmp_path


def test_recorded_trainings_are_audited(harness, recordings):
    """Distances, steps and what was earned; what is not known is said."""
    answer = harness("audit runs --random random")
    assert (answer.status, answer.err) == (0, "")
    out = " ".join(answer.out.split())
    for text in (
        "Bandit-v0: 3 recorded trainings, 2 rewards: plain, square",
        "plain and square distance by steps 0.",
        "Paid most differently: '0', env 0, episode",
        "random actions 2 0 0.25 1.25",
        "trained with plain, last",
        "Not asked: EPIC, DARD and STARC.",
        "an arm, and a recording has none.",
    ):
        assert text in out


def test_damaged_recording_is_status_1(harness, recordings):
    """A line on stderr names it; the others are shown."""
    (recordings / "runs/1/recording-0.json").write_text("{")
    answer = harness("audit runs")
    assert (answer.status, answer.err.count("left out, damaged")) == (1, 1)
    assert "2 recorded trainings" in answer.out


HOVER = """
import numpy as np


def hover(step):
    return -np.abs(step.observation[..., 2])


def upright(step):
    return step.observation[0] > 0.9
"""
IN_PENDULUM = ("--plugin", "hover.py", "--episodes", 1, "--budget", 0)


@pytest.fixture
def hover(tmp_path):
    """The file of two rewards of the pendulum."""
    (tmp_path / "hover.py").write_text(HOVER)


@pytest.mark.parametrize("asked", ["gymnasium:id=Pendulum-v1", "--task gymnasium:id=Pendulum-v1"])
def test_an_environment_is_audited_as_a_task_is(harness, hover, asked):
    """By its name, however it is given; the questions of an arm are left open in a line."""
    answer = harness(f"audit {asked}", "--reward", "hover", *IN_PENDULUM)
    assert (answer.status, answer.err) == (0, "")
    out = " ".join(answer.out.split())
    assert out.startswith("Pendulum-v1: rewards own, hover; discount 0.99")
    assert "own and hover distance by steps 0." in out
    assert "random actions 5 -" in out
    assert "they move an arm, and an environment has none" in out


def test_an_environment_without_names_compares_all_that_pay_it(harness, hover):
    """Its own reward, and those of the file, each two of them; functions are asked about other steps too."""
    data = harness("audit gymnasium:id=Pendulum-v1 --json", *IN_PENDULUM).json
    assert [pair["rewards"] for pair in data["pairs"]] == [["own", "hover"], ["own", "upright"], ["hover", "upright"]]
    assert 0.0 < data["pairs"][2]["EPIC"]["mean"] < 1.0
    assert data["pairs"][0]["reasons"]["EPIC"].startswith("own: it is what the env pays")


def test_a_task_is_named_first_or_by_a_flag(harness):
    """Both say the same."""
    call = ("--reward", "arp", "--json", *FEW)
    first, flag = (harness("audit", *asked, *call).json for asked in (("fd100-reach",), ("--task", "fd100-reach")))
    assert first == flag


def test_an_experiment_of_an_arm_shows_what_its_policies_did(harness, finished):
    """Success beside what each reward pays, and what its rewards pay for; reports say the same of each."""
    finished(2)
    data = harness("audit mine --json").json
    rows = {row["behaviour"]: row for row in data["earned"]}
    assert [*rows] == ["random actions", "trained with baseline, evaluations", "trained with arp, evaluations"]
    (told,) = load_results("mine").returns
    for name in ("baseline", "arp"):
        row = rows[f"trained with {name}, evaluations"]
        assert row["measures"]["success_rate"]["count"] == 2
        assert row["returns"]["arp"]["mean"] == pytest.approx(told.returns["arp"][name].value + told.events[name].value)
    assert 0.0 < data["pairs"][0]["steps"]["mean"] < 1.0
    assert any(line.startswith("arp: Not finishing pays more") for line in data["verdict"])
    assert harness("audit mine --random mine").err.startswith("harness: --random does not go with 'mine'")


def test_logs_of_another_program_are_audited(harness, tmp_path):
    """Their episodes tell whether pay ranks them as success does; what they cannot tell is said."""
    rows = "\n".join(f"{paid},10,{paid}.5,{int(paid > 5)}" for paid in range(10))
    (tmp_path / "run").mkdir()
    (tmp_path / "run/monitor.csv").write_text(f'#{{"t_start": 1.0, "env_id": "Toy-v0"}}\nr,l,t,is_success\n{rows}\n')
    data = harness("audit run --json").json
    assert (data["env"], data["rewards"], data["pairs"]) == ("Toy-v0", ["run"], [])
    assert data["ranks_success"]["run"]["value"] == 1.0
    assert data["earned"][-1]["measures"]["success"]["mean"] == 1.0
    assert "Read: 1 of Monitor of stable-baselines3, a row is an episode" in data["notes"]


def test_reward_that_is_gone_is_left_out_of_an_experiment(harness, quick, gentle):
    """Its policies are shown, and what other rewards pay them; with its file it pays too."""
    assert harness("run", *quick, "--seeds", 1, "--reward", "gentle", "--out", "own", *gentle[:2]).status == 0
    answer = harness("audit own --json")
    data = answer.json
    assert (answer.status, data["notes"][0][:31]) == (0, "What gentle pays is not known: ")
    trained = next(row for row in data["earned"] if row["behaviour"] == "trained with gentle, evaluations")
    assert trained["returns"]["gentle"]["mean"] is None
    assert trained["returns"]["baseline"]["mean"] is not None
    assert harness("audit own --json", *gentle[:2]).json["pairs"][0]["rewards"] == ["baseline", "gentle"]
