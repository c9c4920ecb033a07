"""Runs cells as an array of Slurm jobs."""

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.executor import Job, OnEvent


@dataclass(frozen=True)
class Slurm:
    """Runs an array of Slurm jobs by submitit, one job for each cell. The nodes must see the experiment's folder."""

    partition: Annotated[str, Field(description="Slurm partition for the jobs; empty: the cluster's default")] = ""
    account: Annotated[str, Field(description="Slurm account to charge; empty: the user's default")] = ""
    time: Annotated[int, Field(gt=0, description="time limit of a job [min]")] = 24 * 60
    cpus: Annotated[int, Field(gt=0, description="CPUs per job")] = 1
    memory: Annotated[float, Field(gt=0, description="memory per job [GiB]")] = 4.0
    gpus: Annotated[int, Field(ge=0, description="GPUs per job")] = 0
    requeue: Annotated[int, Field(ge=0, description="how often a job is queued again after its time was up")] = 3
    cluster: Annotated[
        Literal["slurm", "local"],
        Field(description="'slurm' submits the jobs to Slurm; 'local' runs them on this machine, to try them"),
    ] = "slurm"

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        if not jobs:
            return
        from ..slurm_array.array import Array
        from ..slurm_array.cluster import open_cluster

        with open_cluster(
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
