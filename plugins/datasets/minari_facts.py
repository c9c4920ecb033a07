"""What a Minari data set tells of itself, and where its folder is."""

import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from harness.errors import NewerFormat, SchemaError, UsageError, one_line
from harness.files import parse_json, read_bytes, reading

from .dataset import MOST_NUMBERS
from .hdf5_parts import DEEPEST

METADATA, MAIN = Path("data/metadata.json"), Path("data/main_data.hdf5")
NEWEST = (0, 5)
"""The newest version of Minari whose files are known."""
_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})")


def dataset_folder(name: str) -> Path:
    """The folder of a data set: a path, or a name below the place where Minari keeps them.

    Raises:
        UsageError: There is none.
    """
    home = Path(os.environ.get("MINARI_DATASETS_PATH") or Path.home() / ".minari" / "datasets")
    for folder in (Path(os.path.expanduser(name)), home / name):
        if (folder / MAIN).is_file():
            return folder
        if (folder / METADATA).is_file():
            with reading(folder / METADATA, "Minari data set"):
                require_known(folder / METADATA, parse_json(read_bytes(folder / METADATA)))
    raise UsageError(
        f"No Minari data set at '{name}', nor in '{home}': name its folder, which holds {MAIN}, or fetch it with "
        f"minari download {one_line(name, 80)}"
    )


def read_metadata(folder: Path, file: Any) -> dict[str, Any]:
    """What the data set tells of itself; before Minari 0.5 it stood in attributes of the file."""
    path = folder / METADATA
    if not path.is_file():
        return {str(key): value for key, value in file.attrs.items()}
    told = parse_json(read_bytes(path))
    if not isinstance(told, dict):
        raise SchemaError(f"{path} holds no table")
    return told


def require_known(path: Path, metadata: Mapping[str, Any]) -> None:
    """See whether this version can be read.

    Raises:
        NewerFormat: It is newer than those that are known.
        SchemaError: It is stored in another way than HDF5.
    """
    kind = metadata.get("data_format", "hdf5") if isinstance(metadata, dict) else None
    if kind != "hdf5":
        told = one_line(str(kind), 40)
        raise SchemaError(
            f"{path} tells of the format {told!r}, and Minari data sets in hdf5 are read: write it again by "
            "minari.create_dataset_from_buffers(..., data_format='hdf5')"
        )
    found = _VERSION.match(str(metadata.get("minari_version", "")))
    if found and (int(found[1]), int(found[2])) > NEWEST:
        newest = ".".join(map(str, NEWEST))
        raise NewerFormat(f"{path} was written by Minari {found[0]}, and versions up to {newest} are read")


def pictures_of(metadata: Mapping[str, Any]) -> frozenset[str]:
    """Parts of the observation that are left out, pictures and texts, by their place, ``observations/camera``.

    An observation that is one small picture is read.
    """
    text = metadata.get("observation_space")
    if not isinstance(text, str):
        return frozenset()
    try:
        space = json.loads(text)
    except (ValueError, RecursionError):
        return frozenset()
    return frozenset(_picture_places(space, "observations", 0))


def _picture_places(space: Any, place: str, depth: int) -> Iterator[str]:
    if not isinstance(space, dict) or depth > DEEPEST:
        return
    shape, parts = space.get("shape"), space.get("subspaces")
    sizes = [it for it in shape if isinstance(it, int)] if isinstance(shape, list) else []
    is_picture = space.get("dtype") == "uint8" and len(sizes) == 3
    if space.get("type") == "Text" or (is_picture and (depth or math.prod(sizes) > MOST_NUMBERS)):
        yield place
        return
    if isinstance(parts, list):
        parts = {f"_index_{number}": part for number, part in enumerate(parts)}
    for key, part in parts.items() if isinstance(parts, dict) else ():
        yield from _picture_places(part, f"{place}/{key}", depth + 1)
