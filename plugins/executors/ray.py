"""Runs cells on the nodes of a Ray cluster."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.errors import UsageError
from harness.executor import Job, OnEvent
from harness.files import read_bytes, reading

LOCAL = "local"


@dataclass(frozen=True)
class Ray:
    """Runs cells on the nodes of a Ray cluster, in processes like those of the executor ``processes``."""

    address: Annotated[
        str,
        Field(min_length=1, description="cluster's address; 'auto': that of this machine; 'local': starts a cluster"),
    ] = LOCAL
    cpus: Annotated[float, Field(gt=0, description="CPUs that each cell reserves on its node")] = 1.0
    gpus: Annotated[float, Field(ge=0, description="GPUs that each cell reserves on its node")] = 0.0
    retries: Annotated[
        int, Field(ge=0, description="how often a cell is started again after its process or node was lost")
    ] = 3
    fetch: Annotated[
        bool,
        Field(description="whether to send each cell's files back even from nodes that see the experiment's folder"),
    ] = False
    runtime_env: Annotated[str, Field(description="TOML file with Ray's runtime environment; empty: none")] = ""

    def __post_init__(self) -> None:
        """See that the address is one of a cluster that this machine is part of.

        Raises:
            ValueError: It is that of a Ray client.
        """
        if self.address.startswith("ray://"):
            raise ValueError(f"address={self.address}: Ray clients are not supported, run harness on a node of it")

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        if not jobs:
            return
        # Imported here: the settings above are checked before anything runs, and Ray takes a second.
        from ..ray_cluster.connection import connected
        from ..ray_cluster.fleet import Fleet, Needs

        file = Path(self.runtime_env)
        with reading(file, "runtime environment", UsageError):
            environment = tomllib.loads(read_bytes(file).decode()) if self.runtime_env else {}
        cpus = self.cpus * at_once if self.address == LOCAL else None
        with connected(self.address, cpus, environment):
            Fleet(jobs, Needs(self.cpus, self.gpus, self.retries, self.fetch), at_once, on_event).run()
