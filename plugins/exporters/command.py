"""``harness export``: trained policies and their trainings for other programs."""

import importlib
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from harness.authoring.commands import (
    POLICY,
    PluginFiles,
    Store,
    files_in,
    folder_lock,
    is_partial,
    make_folder,
    partial_folder,
    publish,
    read_folder,
    say,
    storage_errors,
    write_whole,
)
from harness.errors import UsageError
from harness.policy import CARD, Network, load_policy
from harness.text import command_text

if TYPE_CHECKING:
    from .episodes import Source


class Form(NamedTuple):
    """A kind of model, and what is needed to make one."""

    module: str
    """The module whose function ``model_of(policy, card)`` returns the bytes of the file."""
    library: str
    extra: str


ONNX = Form("harness_plugins.exporters.onnx_model", "onnx", "export")
TORCHSCRIPT = Form("harness_plugins.exporters.torch_script", "torch", "sb3")


UNFINISHED = ".export.partial"
"""In a folder that is being written, and in one that a killed export left: the same command begins anew there."""


class DatasetForm(NamedTuple):
    """A format of data sets."""

    module: str
    function: str
    library: str
    """What it needs; empty if nothing is."""


MINARI = DatasetForm("harness_plugins.exporters.minari_folder", "write_minari", "h5py")
LEROBOT = DatasetForm("harness_plugins.exporters.lerobot_folder", "write_lerobot", "")


def export(
    folder: Annotated[
        Path,
        typer.Argument(
            help="A cell's folder, or that of a policy; for --csv, --minari and --lerobot an experiment's, or one with "
            "recordings.",
            metavar="DIR",
        ),
    ],
    onnx: Annotated[Path | None, typer.Option(help="Write an ONNX model to this file.", metavar="FILE")] = None,
    torchscript: Annotated[
        Path | None, typer.Option(help="Write a TorchScript model to this file.", metavar="FILE")
    ] = None,
    csv: Annotated[
        bool, typer.Option("--csv", help="Write the trainings of all done cells as CSV files into the folder of --out.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="The folder for --csv.", metavar="DIR")] = None,
    minari: Annotated[
        Path | None,
        typer.Option(help="Write trainings and evaluations as data sets of Minari into this folder.", metavar="DIR"),
    ] = None,
    lerobot: Annotated[
        Path | None,
        typer.Option(help="Write them as data sets of LeRobot into this folder; numbers are float32.", metavar="DIR"),
    ] = None,
    plugin: PluginFiles = None,
) -> int:
    """Write a cell's policy as a model: observations in, scaled actions out, without noise.

    With --csv write what the trainings of an experiment recorded instead, as CSV files. With --minari or --lerobot
    write the episodes of its trainings and evaluations, with what every reward pays for each step.
    """
    places = [(place, form) for place, form in ((minari, MINARI), (lerobot, LEROBOT)) if place is not None]
    if places:
        if csv or out is not None or onnx is not None or torchscript is not None:
            raise UsageError("--minari and --lerobot go without other forms: call the command twice for both")
        return _write_datasets(folder, places, plugin)
    if plugin:
        raise UsageError("--plugin goes with --minari or --lerobot: leave it out")
    files = {file: form for file, form in ((onnx, ONNX), (torchscript, TORCHSCRIPT)) if file is not None}
    if csv != (out is not None) or (csv and files):
        raise UsageError("--csv and --out DIR go together, and without a model: call the command twice for both")
    if out is not None:
        return _write_runs(folder, out)
    if not files:
        raise UsageError(
            "nothing to write: give --onnx FILE or --torchscript FILE, each a file of its own, --csv --out DIR, "
            "--minari DIR or --lerobot DIR"
        )
    _write_models(folder, files)
    return 0


def _write_models(folder: Path, files: dict[Path, Form]) -> None:
    for file in files:
        if file.is_dir() or not file.parent.is_dir():
            raise UsageError(f"{file} cannot be written: it is a folder, or is to be in one that is not there")
    policy, card = _network_in(folder)
    models = {file: _model(form, policy, card) for file, form in files.items()}  # all of them before one is written
    for file, model in models.items():
        write_whole(file, model)
        say(f"Model: {file} ({policy.kind})", err=True)


def _write_runs(folder: Path, out: Path) -> int:
    """Write the trainings as CSV files; the exit status, 1 if a cell is damaged."""
    from harness.authoring.commands import has_recordings
    from harness.results import load_results

    from .csv_runs import write_recordings, write_runs

    if folder.is_dir() and not Store.is_experiment(folder) and has_recordings(folder):
        _tell(_written(out, partial(write_recordings, folder)))
        return 0
    results = load_results(folder)
    if not results.done:
        raise UsageError(f"'{folder}' has no finished cell to export")
    _tell(_written(out, partial(write_runs, results)))
    if results.damaged:
        verify = command_text("harness", "verify", folder)
        say(f"Left out, damaged: {len(results.damaged)} cells; {verify} names them", err=True)
    return 1 if results.damaged else 0


def _write_datasets(folder: Path, places: list[tuple[Path, DatasetForm]], plugin: list[str] | None) -> int:
    """Write data sets, each whole or not at all; the exit status, 1 if a cell is damaged or a reward is left out."""
    from harness.authoring.commands import has_recordings, load_registry, read_given
    from harness.results import load_results

    from .episodes import source_of_recordings, sources_of_runs

    for place, form in places:
        _require_library(form)
        _require_free(place)
    registry = load_registry(given=read_given(plugin))
    damaged = 0
    if folder.is_dir() and not Store.is_experiment(folder) and has_recordings(folder):
        sources = [source_of_recordings(folder, registry)]
    else:
        results = load_results(folder, plugins=plugin or ())
        if not results.done:
            raise UsageError(f"'{folder}' has no finished cell to export")
        sources, damaged = list(sources_of_runs(results, registry)), len(results.damaged)
    left_out: dict[str, None] = {}
    with ExitStack() as held:
        for place, _ in places:  # all of them first: a kill leaves none that looks finished
            held.enter_context(_writing(place))
        for place, form in places:
            write = getattr(importlib.import_module(form.module), form.function)
            for source in sources:
                count = _write_dataset(source, place / f"{source.name}-v0", write)
                say(f"{place / source.name}-v0: {count:,} episodes", err=True)
                left_out |= dict.fromkeys(source.left_out)
    for line in left_out:
        say(line, err=True)
    if damaged:
        say(f"Left out, damaged: {damaged} cells; {command_text('harness', 'verify', folder)} names them", err=True)
    return 1 if damaged or left_out else 0


def _require_free(place: Path) -> None:
    """Raise UsageError if there is something that no killed export left."""
    if place.exists() and not (place / UNFINISHED).is_file() and (not place.is_dir() or any(place.iterdir())):
        raise UsageError(f"'{place}' is there already: name another folder")


@contextmanager
def _writing(place: Path) -> Iterator[None]:
    """Make a folder, keep other exports out of it, and mark it until all that belongs there is written."""
    make_folder(place)
    with storage_errors(place), folder_lock(place / UNFINISHED, f"Another export is writing '{place}'"):
        yield
        (place / UNFINISHED).unlink()


def _write_dataset(source: "Source", whole: Path, write: Callable[["Source", Path], int]) -> int:
    """Write a data set, in place of what a killed export left; how many episodes it has."""
    partial = partial_folder(whole)
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        count = write(source, partial)
        publish(partial, whole)
    finally:
        shutil.rmtree(partial, ignore_errors=True)  # gone if it took its place
    return count


def _require_library(form: DatasetForm) -> None:
    if form.library:
        try:
            importlib.import_module(form.library)
        except ImportError as error:
            raise UsageError(
                f"This export needs {form.library}, which cannot be imported ({error}): "
                "pip install 'fd100-harness[minari]'"
            ) from error


def _written(out: Path, write: Callable[[Path], dict[Path, int]]) -> dict[Path, int]:
    with _writing(out):
        for left in filter(is_partial, files_in(out)):
            if left.name != UNFINISHED:
                left.unlink()  # half a file of a killed export
        return write(out)


def _tell(written: dict[Path, int]) -> None:
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
