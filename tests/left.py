"""What is left in a folder."""

import hashlib

from harness.record import CELLS, LOG, MANIFEST


def files_of(folder):
    """Every file below it, and what is in it."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def left_by_cells(folder):
    """Digests of what the cells of an experiment left; manifests and logs tell of times."""
    paths = [path for path in (folder / CELLS).rglob("*") if path.is_file() and path.name not in (MANIFEST, LOG)]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}
