"""What an evaluation away from home leaves: one folder per policy and simulator, in the experiment's folder.

::

    transfer/<cell id>/<simulator id>/    there only when the evaluation has ended
        manifest.json evaluation.parquet log.txt
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from harness.errors import SchemaError
from harness.record.folder import MANIFEST, POLICY, WEIGHTS
from harness.registry.choice import Choice

FORMAT = 1
FOLDER = "transfer"


@dataclass(frozen=True)
class TransferRecord:
    """How the evaluation of one cell's policy in another simulator ended.

    Attributes:
        cell: Id of the cell that trained the policy.
        simulator: Where it was evaluated.
        policy: SHA-256 of its weights: another policy of the same cell is another result.
        status: ``done`` or ``failed``.
        reason: Why it failed; empty if it did not.
        started: UTC, ISO 8601.
        seconds: Wall time.
        environment: See `harness.experiment.provenance.describe_environment`.
    """

    cell: str
    simulator: Choice
    policy: str
    status: Literal["done", "failed"]
    reason: str = ""
    started: str = ""
    seconds: float = 0.0
    environment: Mapping[str, Any] = field(default_factory=dict)

    def is_of(self, digest: str) -> bool:
        """Whether it tells of the policy that a cell has now; one that has none any more has no other."""
        return digest in ("", self.policy)

    def write(self, folder: Path) -> None:
        """Write ``manifest.json`` into `folder`."""
        data = {"format": FORMAT, **asdict(self), "simulator": self.simulator.to_json()}
        (folder / MANIFEST).write_text(json.dumps(data, indent=1) + "\n")


def read_record(folder: Path) -> TransferRecord | None:
    """The record in a transfer's folder; None where there is none.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    path = folder / MANIFEST
    if not path.is_file():
        return None
    try:
        data = json.loads(path.read_text())
        version = data.pop("format")
        if version > FORMAT:
            raise SchemaError(f"{path} has format {version}, this version reads up to {FORMAT}")
        return TransferRecord(**{**data, "simulator": Choice.from_json(data["simulator"])})
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise SchemaError(f"{path} is no readable record of a transfer: {error!r}") from error


def simulator_id(simulator: Choice) -> str:
    """The folder's name: the simulator's, and a hash of its parameters."""
    text = json.dumps(simulator.to_json()["params"], sort_keys=True, separators=(",", ":"))
    return f"{simulator.name}-{hashlib.sha256(text.encode()).hexdigest()[:12]}"


def policy_digest(cell_folder: Path) -> str:
    """SHA-256 of the weights that a cell left; empty where they are not there any more."""
    path = cell_folder / POLICY / WEIGHTS
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
