"""The cluster that jobs are submitted to."""

import os
import shutil
import stat
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TypeAlias

import submitit
from submitit.core.utils import FailedJobError, FailedSubmissionError

from harness.errors import UsageError, one_line
from harness.files.bounded import STATE, state_folder

from .task import CellTask


def private_folder() -> Path:
    """The folder, made if there is none.

    A job's function comes from a pickle, so whoever writes here runs code as the user. The folder is under the home
    folder, which the nodes of a cluster share, and not in the experiment's, into which colleagues may write.

    Raises:
        UsageError: The folder cannot be made, or somebody else may write into it or put another in its place.
    """
    place = state_folder() / "jobs"
    try:
        missing = [folder for folder in (place, *place.parents) if not folder.exists()]
        for folder in reversed(missing):
            folder.mkdir(mode=0o700, exist_ok=True)
        _check_owner(place)
        for folder in place.resolve().parents:
            _check_above(folder)
    except OSError as error:
        raise UsageError(f"{place}: {error.strerror}. Set {STATE} to a folder of yours that all nodes see") from error
    return place


def _check_owner(place: Path) -> None:
    """Refuse a folder that is another user's, or that others than its owner may read or write; also a link."""
    told = place.lstat()
    if not stat.S_ISDIR(told.st_mode):
        raise UsageError(f"{place} is a link. Jobs are unpickled from there: remove it, or set {STATE}")
    if told.st_uid != os.geteuid():
        raise UsageError(f"{place} is another user's. Jobs are unpickled from there: set {STATE} to a folder of yours")
    if told.st_mode & 0o077:
        raise UsageError(f"{place} is open to others. Jobs are unpickled from there: chmod 700 it, or set {STATE}")


def _check_above(folder: Path) -> None:
    """Refuse a folder in which everybody may rename what is not theirs."""
    mode = folder.stat().st_mode
    if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
        raise UsageError(
            f"{folder} is open to everybody, who could replace the jobs in it: chmod o-w it, or set {STATE}"
        )


MOST: Final = 1000
"""The largest number of jobs in an array. Clusters allow 1,001 by default."""
OVER: Final = frozenset(
    ["BOOT_FAIL", "CANCELLED", "COMPLETED", "DEADLINE", "FAILED", "NODE_FAIL", "OUT_OF_MEMORY", "REVOKED", "TIMEOUT"]
) | {"FINISHED", "INTERRUPTED"}
"""States of jobs that do not run again: Slurm's, and those of submitit on this machine."""
GONE: Final = "not known to the cluster any more"

SubmittedJob: TypeAlias = submitit.Job[None]


class Cluster:
    """Submits jobs, looks after them, and cancels them.

    Attributes:
        folder: The folder for what jobs are read from and what they leave behind, the user's alone.
        at_once: How many jobs run at once.
        is_local: Whether the jobs run on this machine.
    """

    def __init__(self, folder: Path, kind: str, at_once: int, parameters: dict[str, Any]) -> None:
        self.folder, self.at_once, self.is_local = folder, at_once, kind == "local"
        timeouts = parameters.pop("slurm_max_num_timeout")
        self._executor = submitit.AutoExecutor(folder, cluster=kind, slurm_max_num_timeout=timeouts)
        self._executor.update_parameters(**parameters, slurm_array_parallelism=at_once)

    def room(self, running: int) -> int:
        """How many jobs may be submitted while `running` jobs are submitted already.

        On a cluster it is a whole array when no job is left, because the cluster itself limits how many run at once.
        """
        return self.at_once - running if self.is_local else (0 if running else MOST)

    def submit(self, tasks: Sequence[CellTask]) -> list[SubmittedJob]:
        """Submit an array.

        Raises:
            UsageError: The cluster refuses it; says what sbatch said last.
        """
        try:
            return list(self._executor.submit_array(tasks))
        except (FailedJobError, FailedSubmissionError) as error:
            said = str(error).strip().splitlines() or ["nothing"]
            raise UsageError(
                f"Slurm takes no jobs: {one_line(said[-1])}. Run harness where sbatch works, or with "
                "--executor processes; the same command then does the cells that are not done"
            ) from error

    def over(self, jobs: Sequence[SubmittedJob]) -> dict[str, str]:
        """The states of the jobs that do not run any more, by their ids."""
        if self.is_local:
            states = {job.job_id: job.state for job in jobs}
        else:
            known = self._states(sorted({job.job_id.partition("_")[0] for job in jobs}))
            states = {job.job_id: known.get(job.job_id, GONE) for job in jobs}
        return {job: state for job, state in states.items() if state in OVER or state == GONE}

    def cancel(self, jobs: Sequence[SubmittedJob]) -> None:
        """Cancel jobs."""
        if self.is_local:
            for job in jobs:
                job.cancel()
        elif jobs:
            subprocess.run(["scancel", *{job.job_id.partition("_")[0] for job in jobs}], check=False)

    @staticmethod
    def _states(arrays: Sequence[str]) -> dict[str, str]:
        """The states of the jobs of arrays, by squeue. sacct needs a database, which not every cluster has."""
        command = ["squeue", "--noheader", "--array", "--states=all", f"--jobs={','.join(arrays)}", "--format=%i %T"]
        told = subprocess.run(command, capture_output=True, text=True, check=False)
        return dict(line.split(maxsplit=1) for line in told.stdout.splitlines())


@contextmanager
def open_cluster(kind: str, at_once: int, **parameters: Any) -> Iterator[Cluster]:
    """Open a cluster for the block. At its end, what the jobs were read from and what they left behind is removed.

    Args:
        kind: ``slurm``, or ``local`` for jobs on this machine.
        at_once: How many jobs run at once.
        **parameters: Parameters of a job, by submitit's names.

    Raises:
        UsageError: There is no Slurm here, or no folder that is the user's alone.
    """
    place = Path(tempfile.mkdtemp(dir=private_folder()))
    try:
        yield _made_cluster(place, kind, at_once, parameters)
    finally:
        shutil.rmtree(place, ignore_errors=True)  # a job that is being cancelled may still write there


def _made_cluster(place: Path, kind: str, at_once: int, parameters: dict[str, Any]) -> Cluster:
    try:
        return Cluster(place, kind, at_once, parameters)
    except RuntimeError as error:
        raise UsageError(
            f"No Slurm cluster: {one_line(error)}. Run harness where sbatch works, or with --executor processes"
        ) from error
