"""``harness export`` as it is typed."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import onnx
import onnxruntime
import pytest
from numpy.testing import assert_allclose

from harness import load_results
from harness.cli import main
from harness.policy import SquashedGaussian, Uniform, UniformChoice, load_policy
from harness.policy.inverse_kinematics import SHAPES, InverseKinematics
from harness.registry.choice import Choice
from tests.stores import create_store


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Run ``harness export`` with these arguments in an empty folder: status, standard error."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    monkeypatch.chdir(tmp_path)

    def export(*arguments):
        with pytest.raises(SystemExit) as stopped:
            main(["export", *map(str, arguments)])
        return stopped.value.code or 0, capsys.readouterr().err

    return export


@pytest.fixture
def cell(make_network, tmp_path):
    """A cell's folder, as far as its policy goes."""
    make_network(SquashedGaussian, is_normalised=True).save(tmp_path / "cell" / "policy", {"seed": 3})
    return tmp_path / "cell"


@pytest.mark.parametrize("inside", [".", "policy"])
def test_onnx_model_of_a_cell_is_written(call, cell, inside):
    """From the cell's folder or the policy's; it acts as the policy, and has its card."""
    assert call(cell / inside, "--onnx", "model.onnx") == (0, "Model: model.onnx (squashed-gaussian)\n")
    seen = np.ones((3, 5), np.float32)
    (actions,) = onnxruntime.InferenceSession("model.onnx").run(None, {"observation": seen})
    assert_allclose(actions, load_policy(cell / "policy").act(seen), atol=1e-5)
    assert '"seed": 3' in onnx.load("model.onnx").metadata_props[0].value


def _assert_refused(answer, reason, status=2):
    """One line, and nothing written."""
    assert answer[0] == status
    assert reason in answer[1]
    assert answer[1].count("\n") == 1
    assert not [path for path in Path().iterdir() if path.is_file()]


def _arm():
    """Of an arm without any length."""
    shapes = {name: (3, *part) for name, part in SHAPES.items()} | {"tip": (4, 4)}
    weights = {name: np.ones(shape, np.float32) for name, shape in shapes.items()}
    return InverseKinematics(weights, ("revolute",) * 3, "movej", 0.1, {"name": "none"})


@pytest.mark.parametrize("policy", [Uniform((-1.0,), (1.0,)), UniformChoice(3), _arm()], ids=lambda policy: policy.kind)
def test_policy_that_is_no_network_is_refused(call, tmp_path, policy):
    """There is nothing to export."""
    policy.save(tmp_path / "cell" / "policy")
    answer = call("cell", "--onnx", "model.onnx")
    _assert_refused(answer, f"'{policy.kind}', which is no network: it cannot be exported")


def test_without_a_file_there_is_nothing_to_do(call, cell):
    """The options are named."""
    _assert_refused(call(cell), "give --onnx FILE, or --csv --out DIR")


def test_folder_without_a_policy_is_refused(call, tmp_path):
    """As of a cell that failed."""
    _assert_refused(call(tmp_path, "--onnx", "model.onnx"), "holds no policy: give the folder of a cell that is done")


def test_damaged_policy_is_refused(call, cell):
    """With the reason."""
    (cell / "policy" / "card.json").write_text("{")
    _assert_refused(call(cell, "--onnx", "model.onnx"), "holds no readable policy", status=1)


@pytest.mark.parametrize("file", ["nowhere/model.onnx", "."])
def test_file_that_cannot_be_is_refused(call, cell, file):
    """Before anything is made."""
    _assert_refused(call(cell, "--onnx", file), f"{file} cannot be written")


def test_missing_library_names_the_extra(call, cell, monkeypatch):
    """In one line."""
    monkeypatch.setitem(sys.modules, "onnx", None)
    answer = call(cell, "--onnx", "model.onnx")
    _assert_refused(answer, "needs onnx, which cannot be imported")
    assert "pip install 'fd100-harness[export]'" in answer[1]


def test_listing_imports_no_library(monkeypatch, capsys):
    """`harness --all` shows the command by its name and summary alone."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    for module in ("onnx", "harness_plugins.exporters.command"):
        monkeypatch.setitem(sys.modules, module, ModuleType("must_not_be_used"))
    with pytest.raises(SystemExit):
        main(["--all"])
    assert "Write a policy as ONNX model" in capsys.readouterr().out


@pytest.fixture
def experiment(make_cell, make_plan, run_here, tmp_path):
    """Two seeds of two rewards, and one of the null control."""
    arp = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
    cells = [make_cell(seed=seed, reward=reward) for seed in range(2) for reward in (make_cell().reward, arp)]
    run_here(make_plan(*cells, make_cell(seed=2), control={0: 2}), tmp_path / "mine")
    return tmp_path / "mine"


def test_trainings_are_written(call, experiment, tmp_path):
    """A folder for each group and reward, a file for each seed; the null control's apart."""
    assert call(experiment, "--csv", "--out", "runs")[0] == 0
    files = sorted(path.relative_to(tmp_path / "runs").as_posix() for path in (tmp_path / "runs").rglob("*.csv"))
    assert files == [
        f"ideal-wander-fd100-fd100-reach-horizon-5/{name}.csv"
        for name in ("arp/seed-0", "arp/seed-1", "baseline-control/seed-2", "baseline/seed-0", "baseline/seed-1")
    ]


def test_folders_of_trainings_are_told(call, experiment):
    """With how many runs there are in each, as `harness eta` takes them."""
    _, told = call(experiment, "--csv", "--out", "runs")
    assert "runs/ideal-wander-fd100-fd100-reach-horizon-5/arp: 2 runs\n" in told
    assert "runs/ideal-wander-fd100-fd100-reach-horizon-5/baseline-control: 1 run\n" in told


def _without_p(told):
    """Whatever `harness eta` prints but p: a CSV file does not tell its seed, so runs are no pairs there."""
    if isinstance(told, dict):
        return {key: _without_p(value) for key, value in told.items() if key not in ("p", "p_corrected")}
    return [_without_p(item) for item in told] if isinstance(told, list) else told


def test_indices_of_exported_trainings_are_those_of_the_experiment(call, experiment, capsys):
    """`harness eta` on the files says what it says of the traces, ruler and behaviour included."""
    call(experiment, "--csv", "--out", "runs")
    place = "runs/ideal-wander-fd100-fd100-reach-horizon-5"
    cells = load_results(experiment).done_cells
    traces = {
        name: [f"mine/cells/{cell.id}/trace.parquet" for cell in cells if cell.reward.name == name]
        for name in ("baseline", "arp")
    }
    told = []
    for baseline, proposed in (
        ([f"{place}/baseline/*.csv"], [f"{place}/arp/*.csv"]),
        (traces["baseline"], traces["arp"]),
    ):
        flags = [part for path in baseline for part in ("--baseline", path)]
        flags += [part for path in proposed for part in ("--proposed", path)]
        rewards = ("--baseline-reward", "baseline", "--proposed-reward", "arp")
        with pytest.raises(SystemExit):
            main(["eta", *flags, *rewards, "--json"])
        told.append(_without_p(json.loads(capsys.readouterr().out)))
    assert told[0] == told[1]


def test_damaged_cell_is_left_out_of_the_trainings(call, experiment, tmp_path):
    """And told, with status 1."""
    sorted(experiment.glob("cells/*/trace.parquet"))[0].write_bytes(b"PAR1")
    status, told = call(experiment, "--csv", "--out", "runs")
    assert (status, len(list((tmp_path / "runs").rglob("*.csv")))) == (1, 4)
    assert "Left out, damaged: 1 cells" in told


def test_recordings_of_no_experiment_are_written(call, tmp_path):
    """Each under its own path, and those of final policies too."""
    loose = Path(__file__).parents[2] / "compatibility" / "recordings_1" / "loose"
    assert call(loose, "--csv", "--out", "runs")[0] == 0
    files = {path.relative_to(tmp_path / "runs").as_posix() for path in (tmp_path / "runs").rglob("*.csv")}
    assert {"own-0.csv", "own-0/evaluation.csv", "slow-1.csv"} <= files


@pytest.mark.parametrize("flags", [["--csv"], ["--out", "runs"], ["--csv", "--out", "runs", "--onnx", "model.onnx"]])
def test_flags_that_do_not_go_together_are_refused(call, cell, flags):
    """Before anything is written."""
    _assert_refused(call(cell, *flags), "--csv and --out DIR go together, and without a model")


def test_experiment_without_a_finished_cell_has_no_trainings(call, make_cell, make_plan, tmp_path):
    """Nothing is made."""
    create_store(tmp_path / "mine", make_plan(make_cell()))
    status, told = call("mine", "--csv", "--out", "runs")
    assert (status, "has no finished cell to export" in told) == (2, True)
    assert not (tmp_path / "runs").exists()
