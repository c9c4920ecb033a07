"""``harness export``: a trained policy for other programs."""

import importlib
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from harness.errors import UsageError
from harness.files.whole_file import write_whole
from harness.policy import CARD, Network, load_policy
from harness.policy.folder import read_folder
from harness.record.folder import POLICY


class Form(NamedTuple):
    """A kind of model, and what it takes to make one."""

    module: str
    """Whose function ``model_of(policy, card)`` gives the bytes of the file."""
    library: str
    extra: str


ONNX = Form("harness_plugins.exporters.onnx_model", "onnx", "export")
TORCHSCRIPT = Form("harness_plugins.exporters.torch_script", "torch", "sb3")


def export(
    cell: Annotated[Path, typer.Argument(help="A cell's folder, or the folder of a policy.", metavar="CELL")],
    onnx: Annotated[Path | None, typer.Option(help="Write an ONNX model to this file.", metavar="FILE")] = None,
    torchscript: Annotated[
        Path | None, typer.Option(help="Write a TorchScript model to this file.", metavar="FILE")
    ] = None,
) -> None:
    """Write a cell's policy as a model: observations in, scaled actions out, without noise."""
    files = {file: form for file, form in ((onnx, ONNX), (torchscript, TORCHSCRIPT)) if file is not None}
    if not files:
        raise UsageError("nothing to write: give --onnx FILE or --torchscript FILE, each a file of its own")
    for file in files:
        if file.is_dir() or not file.parent.is_dir():
            raise UsageError(f"{file} cannot be written: it is a folder, or is to be in one that is not there")
    policy, card = _network_in(cell)
    models = {file: _model(form, policy, card) for file, form in files.items()}  # all of them before one is written
    for file, model in models.items():
        write_whole(file, model)
        typer.echo(f"Model: {file} ({policy.kind})", err=True)


def _network_in(folder: Path) -> tuple[Network, dict[str, Any]]:
    """The policy and its card."""
    home = next((home for home in (folder, folder / POLICY) if (home / CARD).is_file()), None)
    if home is None:
        raise UsageError(f"{folder} holds no policy: give the folder of a cell that is done, or of a policy")
    policy = load_policy(home)
    if not isinstance(policy, Network):
        raise UsageError(f"{home} holds a policy of kind '{policy.kind}', which is no network: it cannot be exported")
    return policy, read_folder(home)[0]


def _model(form: Form, policy: Network, card: dict[str, Any]) -> bytes:
    try:
        importlib.import_module(form.library)
    except ImportError as error:
        raise UsageError(
            f"This export needs {form.library}, which cannot be imported ({error}): "
            f"pip install 'fd100-harness[{form.extra}]'"
        ) from error
    model: bytes = importlib.import_module(form.module).model_of(policy, card)
    return model
