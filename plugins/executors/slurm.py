"""Runs cells as an array of Slurm jobs."""

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.executor import Job, OnEvent


@dataclass(frozen=True)
class Slurm:
    """Runs an array of Slurm jobs by submitit, one job for each cell. The nodes must see the experiment's folder."""

    partition: Annotated[str, Field(description="of the cluster; by default its own choice")] = ""
    account: Annotated[str, Field(description="that is charged; by default the user's own")] = ""
    time: Annotated[int, Field(gt=0, description="minutes that a job may take")] = 24 * 60
    cpus: Annotated[int, Field(gt=0, description="CPUs of a job")] = 1
    memory: Annotated[float, Field(gt=0, description="GiB of a job")] = 4.0
    gpus: Annotated[int, Field(ge=0, description="GPUs of a job")] = 0
    requeue: Annotated[int, Field(ge=0, description="how often a job goes on whose time was up")] = 3
    cluster: Annotated[
        Literal["slurm", "local"], Field(description="'local' runs the jobs on this machine, to try them")
    ] = "slurm"

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """See `harness.executor.Executor`."""
        if not jobs:
            return
        from ..slurm_array.array import Array
        from ..slurm_array.cluster import open_cluster

        with open_cluster(
            jobs[0].folder.parent,
            self.cluster,
            at_once,
            name="harness",
            timeout_min=self.time,
            cpus_per_task=self.cpus,
            mem_gb=self.memory,
            gpus_per_node=self.gpus,
            slurm_partition=self.partition or None,
            slurm_account=self.account or None,
            slurm_max_num_timeout=self.requeue,
        ) as cluster:
            Array(jobs, cluster, on_event).run()
