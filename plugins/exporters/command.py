"""``harness export``: trained policies and their trainings for other programs."""

import importlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from harness.cli.output import say
from harness.errors import UsageError
from harness.files.bounded import files_in, is_partial, write_whole
from harness.policy import load_policy
from harness.policy.policy import Network, read_folder
from harness.record import POLICY, Store
from harness.record.folder import CARD
from harness.record.out_folder import folder_lock, make_folder, storage_errors
from harness.text import command_text

UNFINISHED = ".export.partial"
"""In a folder that is being written, and in one that a killed export left: the same command begins anew there."""


def export(
    folder: Annotated[
        Path,
        typer.Argument(
            help="A cell's folder, or that of a policy; for --csv an experiment's, or one with recordings.",
            metavar="DIR",
        ),
    ],
    onnx: Annotated[Path | None, typer.Option(help="Write an ONNX model to this file.", metavar="FILE")] = None,
    csv: Annotated[
        bool, typer.Option("--csv", help="Write the trainings of all done cells as CSV files into the folder of --out.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="The folder for --csv.", metavar="DIR")] = None,
) -> int:
    """Write a cell's policy as a model: observations in, scaled actions out, without noise.

    With --csv write what the trainings of an experiment recorded instead, as CSV files.
    """
    if csv != (out is not None) or (csv and onnx is not None):
        raise UsageError("--csv and --out DIR go together, and without a model: call the command twice for both")
    if out is not None:
        return _write_runs(folder, out)
    if onnx is None:
        raise UsageError("nothing to write: give --onnx FILE, or --csv --out DIR")
    _write_model(folder, onnx)
    return 0


def _write_model(folder: Path, file: Path) -> None:
    if file.is_dir() or not file.parent.is_dir():
        raise UsageError(f"{file} cannot be written: it is a folder, or is to be in one that is not there")
    policy, card = _network_in(folder)
    try:
        importlib.import_module("onnx")
    except ImportError as error:
        raise UsageError(
            f"This export needs onnx, which cannot be imported ({error}): pip install 'fd100-harness[export]'"
        ) from error
    from .onnx_model import model_of

    write_whole(file, model_of(policy, card))
    say(f"Model: {file} ({policy.kind})", err=True)


def _write_runs(folder: Path, out: Path) -> int:
    """Write the trainings as CSV files; the exit status, 1 if a cell is damaged."""
    from harness import load_results
    from harness.results.recordings.recordings import has_recordings

    from .csv_runs import write_recordings, write_runs

    if folder.is_dir() and not Store.is_experiment(folder) and has_recordings(folder):
        _write(out, partial(write_recordings, folder))
        return 0
    results = load_results(folder)
    if not results.done:
        raise UsageError(f"'{folder}' has no finished cell to export")
    _write(out, partial(write_runs, results))
    if results.damaged:
        verify = command_text("harness", "verify", folder)
        say(f"Left out, damaged: {len(results.damaged)} cells; {verify} names them", err=True)
    return 1 if results.damaged else 0


def _write(out: Path, write: Callable[[Path], dict[Path, int]]) -> None:
    """Write into a folder that is marked until all that belongs there is written, and tell what was."""
    make_folder(out)
    with storage_errors(out), folder_lock(out / UNFINISHED, f"Another export is writing '{out}'"):
        for left in filter(is_partial, files_in(out)):
            if left.name != UNFINISHED:
                left.unlink()  # half a file of a killed export
        written = write(out)
        (out / UNFINISHED).unlink()
    for place, count in written.items():
        say(f"{place}: {count} {'run' if count == 1 else 'runs'}", err=True)


def _network_in(folder: Path) -> tuple[Network, dict[str, Any]]:
    """The policy and its card, from the folder of a cell or of a policy.

    Raises:
        UsageError: The folder holds no policy, or one that is no network.
    """
    home = next((home for home in (folder, folder / POLICY) if (home / CARD).is_file()), None)
    if home is None:
        raise UsageError(f"{folder} holds no policy: give the folder of a cell that is done, or of a policy")
    policy = load_policy(home)
    if not isinstance(policy, Network):
        raise UsageError(f"{home} holds a policy of kind '{policy.kind}', which is no network: it cannot be exported")
    return policy, read_folder(home)[0]
