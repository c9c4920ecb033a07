"""Clusters on this machine: Ray's, of two nodes, and Slurm's, of one."""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import psutil
import pytest

from harness.testing.odd_cells import installed


class TwoNodes:
    """A head without room for cells, which the test belongs to, and nodes that come and go.

    Attributes:
        address: Of the cluster.
        nodes: Those that are there.
    """

    def __init__(self) -> None:
        from ray.cluster_utils import Cluster

        self._cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
        self.address, self.nodes = self._cluster.address, []

    def add(self, cpus: int = 2, **env_vars: str) -> None:
        """Start a node, with other environment variables than this process where they are given."""
        self.nodes.append(self._cluster.add_node(num_cpus=cpus, env_vars=env_vars or None))

    def kill_node(self) -> None:
        """The oldest node is gone, all of its processes at once."""
        self._cluster.remove_node(self.nodes.pop(0), allow_graceful=False)

    def slots(self) -> list[psutil.Process]:
        """The processes on all nodes that do cells."""
        return [process for process in psutil.process_iter(["name"]) if process.info["name"].startswith("ray::Slot")]

    def stop(self) -> None:
        """End all of it."""
        self._cluster.shutdown()


@pytest.fixture
def two_nodes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A cluster of two nodes that have the kit's cells, as this process does."""
    pytest.importorskip("ray")
    monkeypatch.chdir(tmp_path)  # Python finds modules where it is started: here there are none
    with installed(tmp_path / "site-packages"):
        cluster = TwoNodes()
        try:
            cluster.add()
            cluster.add()
            yield cluster
        finally:
            cluster.stop()


DAEMONS = os.pathsep.join([os.environ["PATH"], "/usr/sbin"])
"""Where Debian puts them."""
SLURM_CONF = """
ClusterName=harness
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
MpiDefault=none
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=8000
PartitionName=all Nodes=ALL Default=YES
"""


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A Slurm cluster of this machine, four cells wide."""
    daemons = ("munged", "slurmctld", "slurmd")
    missing = [name for name in (*daemons, "sbatch") if shutil.which(name, path=DAEMONS) is None]
    if missing or os.getuid() != 0:
        pytest.skip(
            f"needs root and {', '.join(missing or daemons)}: apt-get install slurmctld slurmd slurm-client munge"
        )
    folder = tmp_path_factory.mktemp("slurm")
    (folder / "key").write_bytes(os.urandom(1024))
    (folder / "key").chmod(0o600)
    for path in (folder, *folder.parents[:-2]):
        path.chmod(0o755)  # munge wants to be seen by all
    controller_port, node_port = _free_port(), _free_port()
    conf = folder / "slurm.conf"
    conf.write_text(SLURM_CONF.format(
        host=socket.gethostname(), folder=folder, controller_port=controller_port, node_port=node_port
    ))  # fmt: skip
    files = [f"--{name}={folder / name}" for name in ("pid-file", "log-file", "seed-file")]
    commands = (
        ["munged", "--foreground", "--force", f"--key-file={folder / 'key'}", f"--socket={folder}/munge.sock", *files],
        ["slurmctld", "-D", "-i"],
        ["slurmd", "-D"],
    )
    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setenv("SLURM_CONF", str(conf))
        patch.setenv("PATH", DAEMONS)
        log = stack.enter_context((folder / "log").open("w"))
        for command in commands:
            process = stack.enter_context(subprocess.Popen(command, stdout=log, stderr=log))
            stack.callback(process.terminate)
        _wait_for_idle_node(folder / "log")
        yield


def _free_port() -> int:
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        port: int = server.getsockname()[1]
        return port


def _wait_for_idle_node(log: Path) -> None:
    until = time.monotonic() + 30.0
    while time.monotonic() < until:
        told = subprocess.run(["sinfo", "--noheader", "--format=%t"], capture_output=True, text=True, check=False)
        if told.stdout.strip() == "idle":
            return
        time.sleep(0.5)
    pytest.fail(f"Slurm does not start: {log.read_text()[-2000:]}")
