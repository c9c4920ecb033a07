"""The defaults that an algorithm has in an environment: written into the cell, and told wherever it is named."""

import re
from dataclasses import replace

import pytest

from harness import load_registry
from harness.cli.progress import foreseen_lines
from harness.errors import PluginError
from harness.experiment.experiment import check
from harness.experiment.foresee import foresee
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_options import RunOptions
from harness.record import Store
from harness.registry import Choice, read_given
from tests.stores import create_store

FITTED = """
from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Fitted:
    gamma: float = 0.5
    depth: int = 1

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[frozenset] = frozenset({"continuous"})
    in_environments: ClassVar[dict] = {"gamma": 0.9}

    def train(self, env, steps, seed, progress):
        raise NotImplementedError
"""
BEGUN = "the folder was begun with ppo:gamma=0.8 and goes on so; in a new folder it is ppo:gamma=0.99"


def _asked(**keys):
    return check_experiment({"task": "toy", "algo": "ppo", "seeds": 2, "steps": 80, "evaluation_episodes": 3, **keys})


def _labels(plan):
    return list(dict.fromkeys(cell.algorithm.label for cell in plan.cells))


@pytest.fixture(name="begun")
def _begun(registry, given, tmp_path):
    """Plan what is asked for in the folder `old`, in which version 0.2 planned the same without these defaults."""

    def plan(out=tmp_path / "old", **keys):
        return check(_asked(**keys), RunOptions(out=out), given).plan

    old = expand(_asked(), registry)
    create_store(tmp_path / "old", replace(old, cells=tuple(map(_as_in_0_2, old.cells))))
    return plan


def _as_in_0_2(cell):
    params = tuple((key, 0.8 if key == "gamma" else value) for key, value in cell.algorithm.params)
    return replace(cell, algorithm=Choice(cell.algorithm.name, params, cell.algorithm.name))


def test_the_discount_that_nobody_chose_is_the_fields(registry, subtests):
    """As if the user had written it. What was chosen stays, and so does what a preset brings."""
    for algo, label in [
        ("ppo", "ppo:gamma=0.99"),
        ("sac-fast:net_arch=4", "sac-fast:gamma=0.99,net_arch=4"),
        ("ppo:gamma=0.8", "ppo"),
        ("ppo:gamma=0.9", "ppo:gamma=0.9"),
        ("ppo:preset=unity", "ppo:preset=unity"),
        ("random", "random"),
    ]:
        with subtests.test(algo=algo, label=label):
            assert _labels(expand(_asked(algo=algo), registry)) == [label]


def test_an_arm_has_the_defaults_of_the_fields(registry):
    """They were found there."""
    assert _labels(expand(_asked(task="fd100-reach", sim="kinematic"), registry)) == ["ppo"]


def test_the_same_written_out_is_the_same_cell(registry):
    """Two ways to ask for it are asked for once."""
    assert expand(_asked(algo="ppo,ppo:gamma=0.99"), registry).cells == expand(_asked(), registry).cells


@pytest.mark.parametrize("algo", ["ppo", "ppo:gamma=0.8"])
def test_a_resolved_experiment_plans_the_same_cells(registry, algo):
    """Its file says every parameter, so nothing is filled in."""
    plan = expand(_asked(algo=algo), registry)
    assert expand(check_experiment(plan.resolved), registry).cells == plan.cells


def test_anybodys_algorithm_may_declare_them(tmp_path, given):
    """By the same class variable."""
    (tmp_path / "fitted.py").write_text(FITTED)
    registry = load_registry(given=(*given, *read_given([tmp_path / "fitted.py"])))
    assert _labels(expand(_asked(algo="fitted:depth=2"), registry)) == ["fitted:gamma=0.9,depth=2"]


@pytest.mark.parametrize(("old", "new"), [('"gamma"', '"gama"'), ("0.9}", '"high"}')])
def test_defaults_that_do_not_fit_are_the_plugins_fault(tmp_path, given, old, new):
    """The user did not type them."""
    (tmp_path / "fitted.py").write_text(FITTED.replace(old, new))
    registry = load_registry(given=(*given, *read_given([tmp_path / "fitted.py"])))
    with pytest.raises(PluginError, match=r"'fitted' of package .* does not take what its in_environments declares"):
        expand(_asked(algo="fitted"), registry)


def test_a_folder_goes_on_with_the_defaults_that_it_was_begun_with(begun):
    """The same command asks for the same cells, and says so."""
    plan = begun()
    assert _labels(plan) == ["ppo"]
    assert BEGUN in plan.warnings


def test_the_ids_in_a_begun_folder_stay(begun, tmp_path):
    """None is trained a second time."""
    assert begun().cells == Store.open(tmp_path / "old").read_plan().cells


def test_an_algorithm_that_is_new_in_a_begun_folder_has_todays_defaults(begun):
    """Beside the one that goes on."""
    assert _labels(begun(algo="ppo,sac-fast")) == ["ppo", "sac-fast:gamma=0.99"]


def test_todays_default_can_be_asked_for_in_a_begun_folder(begun):
    """By its value."""
    plan = begun(algo="ppo:gamma=0.99")
    assert _labels(plan) == ["ppo:gamma=0.99"]
    assert BEGUN not in plan.warnings


def test_another_folder_has_todays_defaults(begun, tmp_path):
    """Whatever lies beside it."""
    assert _labels(begun(tmp_path / "new")) == ["ppo:gamma=0.99"]


def test_a_begun_folder_of_the_default_name_is_found(begun, tmp_path, monkeypatch):
    """It was named for the cells of then."""
    monkeypatch.chdir(tmp_path)
    old = begun()
    assert _labels(begun(None)) == ["ppo:gamma=0.99"]
    (tmp_path / "results" / "runs").mkdir(parents=True)
    (tmp_path / "old").rename(tmp_path / "results" / "runs" / f"toy-ppo-{old.id}")
    assert begun(None).cells == old.cells


def test_looks_that_were_begun_go_on(registry, given, tmp_path):
    """Their seeds depend on the algorithm's label, too."""
    keys = {"task": "toy", "until": "decided", "looks": [4, 6], "steps": 80, "evaluation_episodes": 3}
    old = expand(check_experiment({**keys, "algo": "ppo:gamma=0.8"}), registry)
    create_store(tmp_path / "old", old)
    asked = check_experiment({**keys, "algo": "ppo"})
    assert check(asked, RunOptions(out=tmp_path / "old"), given).plan.cells == old.cells


def test_a_dry_run_tells_the_discount(begun, given, tmp_path):
    """Of a new folder, and of one that has a default of then."""
    for out, told in (("new", "to do: toy · ppo:gamma=0.99 · near"), ("old", "to do: toy · ppo:gamma=0.8 · near")):
        lines = foreseen_lines(foresee(check(_asked(), RunOptions(out=tmp_path / out), given)))
        assert any(re.match(re.escape(told), line) for line in lines)
