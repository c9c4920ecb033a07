"""What an evaluation away from home leaves: one folder per policy and simulator, in the experiment's folder.

::

    transfer/<cell id>/<simulator id>/    there only when the evaluation has ended
        manifest.json evaluation.parquet log.txt
"""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import ConfigDict, StringConstraints, with_config

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import digest_of
from harness.record import MANIFEST, POLICY
from harness.record.cell import Ending, read_record, require_files
from harness.record.file_forms import Chosen
from harness.record.folder import WEIGHTS
from harness.registry import Choice

TRANSFER = "transfer"
"""The folder in that of the experiment."""


@with_config(ConfigDict(strict=True, extra="forbid"))
@dataclass(frozen=True)
class TransferRecord(Ending):
    """How the evaluation of one cell's policy in another simulator ended.

    Attributes:
        cell: Id of the cell that trained the policy.
        simulator: Where it was evaluated.
        policy: SHA-256 of its weights: another policy of the same cell is another result.
    """

    cell: Annotated[str, StringConstraints(min_length=1, max_length=1_000)]
    simulator: Chosen
    policy: Annotated[str, StringConstraints(max_length=100_000)]

    def is_of(self, digest: str) -> bool:
        """Whether it tells of the policy that a cell has now; one that has none any more has no other."""
        return digest in ("", self.policy) or self.status == "damaged"

    FORMAT: ClassVar[int] = 2


def read_transfer(folder: Path) -> TransferRecord | None:
    """The record in a transfer's folder, with the status ``damaged`` if that is not what was written; None without one.

    Raises:
        NewerFormat: A newer version wrote it.
    """
    if not (folder / MANIFEST).exists():
        return None
    try:
        record = read_record_of(folder)
        require_files(folder, record)
    except NewerFormat:
        raise
    except SchemaError as error:
        name = folder.name.rpartition("-")[0]
        reason = f"{error}; harness transfer does it again"
        return TransferRecord(folder.parent.name, Choice(name, (), name), "", status="damaged", reason=reason)
    return record


def read_record_of(folder: Path) -> TransferRecord:
    """The record in a transfer's folder, as it was written.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    return read_record(folder, TransferRecord, "record of a transfer")


def simulator_id(simulator: Choice) -> str:
    """The folder's name: the simulator's, and a hash of its parameters."""
    text = json.dumps(simulator.to_json()["params"], sort_keys=True, separators=(",", ":"))
    if "/" in simulator.name:  # which a folder's name cannot hold
        text = f"{simulator.name} {text}"
    return f"{simulator.name.replace('/', '-')}-{hashlib.sha256(text.encode()).hexdigest()[:12]}"


def policy_digest(cell_folder: Path) -> str:
    """SHA-256 of the weights that a cell left; empty where they are not there any more."""
    path = cell_folder / POLICY / WEIGHTS
    return digest_of(path) if path.is_file() else ""
