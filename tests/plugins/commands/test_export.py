"""``harness export`` as it is typed."""

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

from harness.cli import main
from harness.policy import InverseKinematics, Policy, SquashedGaussian, Uniform, UniformChoice, load_policy
from harness.policy.inverse_kinematics import SHAPES


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path):
    """Run ``harness export`` with these arguments in an empty folder: status, standard error."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    monkeypatch.chdir(tmp_path)

    def export(*arguments: object) -> tuple[int, str]:
        with pytest.raises(SystemExit) as stopped:
            main(["export", *map(str, arguments)])
        return stopped.value.code or 0, capsys.readouterr().err

    return export


@pytest.fixture
def cell(make_network, tmp_path: Path) -> Path:
    """A cell's folder, as far as its policy goes."""
    make_network(SquashedGaussian, is_normalised=True).save(tmp_path / "cell" / "policy", {"seed": 3})
    return tmp_path / "cell"


@pytest.mark.parametrize("inside", [".", "policy"])
def test_onnx_model_of_a_cell_is_written(call, cell: Path, inside: str):
    """From the cell's folder or the policy's; it acts as the policy, and has its card."""
    assert call(cell / inside, "--onnx", "model.onnx") == (0, "Model: model.onnx (squashed-gaussian)\n")
    seen = np.ones((3, 5), np.float32)
    (actions,) = onnxruntime.InferenceSession("model.onnx").run(None, {"observation": seen})
    np.testing.assert_allclose(actions, load_policy(cell / "policy").act(seen), atol=1e-5)
    assert '"seed": 3' in onnx.load("model.onnx").metadata_props[0].value


@pytest.mark.filterwarnings("ignore:`torch.jit.load` is deprecated:DeprecationWarning")
def test_both_models_are_written(call, cell: Path):
    """One call, two files."""
    status, told = call(cell, "--onnx", "model.onnx", "--torchscript", "model.pt")
    assert (status, told.count("Model: ")) == (0, 2)
    seen = np.ones((3, 5), np.float32)
    actions = torch.jit.load("model.pt")(torch.from_numpy(seen)).numpy()
    np.testing.assert_allclose(actions, load_policy(cell / "policy").act(seen), atol=1e-5)


def _assert_refused(answer: tuple[int, str], reason: str, status: int = 2) -> None:
    """One line, and nothing written."""
    assert answer[0] == status
    assert reason in answer[1]
    assert answer[1].count("\n") == 1
    assert not [path for path in Path().iterdir() if path.is_file()]


def _arm() -> InverseKinematics:
    """Of an arm without any length."""
    shapes = {name: (3, *part) for name, part in SHAPES.items()} | {"tip": (4, 4)}
    weights = {name: np.ones(shape, np.float32) for name, shape in shapes.items()}
    return InverseKinematics(weights, ("revolute",) * 3, "movej", 0.1, {"name": "none"})


@pytest.mark.parametrize("policy", [Uniform((-1.0,), (1.0,)), UniformChoice(3), _arm()], ids=lambda policy: policy.kind)
def test_policy_that_is_no_network_is_refused(call, tmp_path: Path, policy: Policy):
    """There is nothing to export."""
    policy.save(tmp_path / "cell" / "policy")
    answer = call("cell", "--onnx", "model.onnx")
    _assert_refused(answer, f"'{policy.kind}', which is no network: it cannot be exported")


def test_without_a_file_there_is_nothing_to_do(call, cell: Path):
    """The options are named."""
    _assert_refused(call(cell), "give --onnx FILE or --torchscript FILE")


def test_folder_without_a_policy_is_refused(call, tmp_path: Path):
    """As of a cell that failed."""
    _assert_refused(call(tmp_path, "--onnx", "model.onnx"), "holds no policy: give the folder of a cell that is done")


def test_damaged_policy_is_refused(call, cell: Path):
    """With the reason."""
    (cell / "policy" / "card.json").write_text("{")
    _assert_refused(call(cell, "--onnx", "model.onnx"), "holds no readable policy", status=1)


@pytest.mark.parametrize("file", ["nowhere/model.onnx", "."])
def test_file_that_cannot_be_is_refused(call, cell: Path, file: str):
    """Before anything is made."""
    _assert_refused(call(cell, "--onnx", file), f"{file} cannot be written")


@pytest.mark.parametrize(
    ("library", "option", "extra"), [("onnx", "--onnx", "export"), ("torch", "--torchscript", "sb3")]
)
def test_missing_library_names_the_extra(
    call, cell: Path, monkeypatch: pytest.MonkeyPatch, library: str, option: str, extra: str
):
    """And the other file is not written either."""
    other = {"--onnx": "--torchscript", "--torchscript": "--onnx"}[option]
    monkeypatch.setitem(sys.modules, library, None)
    answer = call(cell, other, "other.file", option, "model.file")
    _assert_refused(answer, f"needs {library}, which cannot be imported")
    assert f"pip install 'fd100-harness[{extra}]'" in answer[1]


def test_listing_imports_no_library(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """`harness --help` shows the command by its name and summary alone."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    for module in ("onnx", "torch", "harness_plugins.commands.export"):
        monkeypatch.setitem(sys.modules, module, ModuleType("must_not_be_used"))
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "Write a policy as ONNX or TorchScript model." in capsys.readouterr().out
