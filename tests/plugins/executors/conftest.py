"""Clusters on this machine: Ray's, of two nodes, and Slurm's, of one."""

import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, suppress
from pathlib import Path

import psutil
import pytest

from harness.registry import Choice


class TwoNodes:
    """A head without room for cells, which the test belongs to, and nodes that come and go.

    Each node has a network of its own, as another machine has, and its own folder in place of `hidden`.

    Attributes:
        address: Of the cluster.
        nodes: Names of those that are there.
    """

    def __init__(self, hidden: Path) -> None:
        self._hidden, self._started = hidden, 0
        self._name = f"ray{secrets.token_hex(3)}"  # a network that was deleted is still there for a moment
        self._place = Path(tempfile.mkdtemp(prefix="ray-", dir="/tmp"))  # paths of sockets have to be short
        self._log = (self._place / "log").open("w")
        self._processes: list[subprocess.Popen[bytes]] = []
        self.address, self.nodes = "10.77.0.1:6399", []
        self._ip(f"link add {self._name} type bridge")
        self._ip(f"addr add 10.77.0.1/24 dev {self._name}")
        self._ip(f"link set {self._name} up")

    def begin(self):
        """Start the head, and two nodes."""
        head = ["--head", "--port=6399", "--node-ip-address=10.77.0.1", "--num-cpus=0", f"--temp-dir={self._place}"]
        self._processes.append(self._start([*head, "--include-dashboard=false"]))
        self.wait(1)
        self.add()
        self.add()
        self.wait(3)

    def add(self, cpus=2, **env_vars):
        """Start a node, with other environment variables than this process where they are given."""
        self._started += 1
        name, address = f"{self._name}-{self._started}", f"10.77.0.{10 + self._started}"
        self._ip(f"netns add {name}")
        self._ip(f"link add {name} type veth peer name eth0 netns {name}")
        self._ip(f"link set {name} master {self._name} up")
        self._ip(f"-n {name} addr add {address}/24 dev eth0")
        self._ip(f"-n {name} link set eth0 up")
        self._ip(f"-n {name} link set lo up")
        hide = f'mount -t tmpfs tmpfs {self._hidden} && mount -t tmpfs tmpfs {self._place} && exec "$@"'
        inside = ["ip", "netns", "exec", name, "sh", "-c", hide, "sh"]
        node = [f"--address={self.address}", f"--node-ip-address={address}", f"--num-cpus={cpus}"]
        self._processes.append(self._start([*node], inside, env_vars))
        self.nodes.append(name)

    def wait(self, count):
        """Until the cluster has so many nodes, the head included."""
        code = "import ray, sys, time\n" \
            f"ray.init('{self.address}', log_to_driver=False, logging_level='ERROR')\n" \
            f"while sum(node['Alive'] for node in ray.nodes()) < {count}: time.sleep(0.2)"  # fmt: skip
        until = time.monotonic() + 60.0
        while subprocess.run([sys.executable, "-c", code], stderr=self._log, check=False, timeout=25).returncode:
            assert time.monotonic() < until, (self._place / "log").read_text()[-2000:]

    def kill_node(self):
        """The oldest node is gone, all of its processes at once."""
        name = self.nodes.pop(0)
        for pid in self._ip(f"netns pids {name}").split():
            with suppress(ProcessLookupError):
                os.kill(int(pid), signal.SIGKILL)
        self._ip(f"netns del {name}")

    def slots(self):
        """The processes on all nodes that do cells."""
        here = {int(pid) for name in self.nodes for pid in self._ip(f"netns pids {name}").split()}
        running = [process for process in psutil.process_iter(["name"]) if process.pid in here]
        return [process for process in running if process.info["name"].startswith("ray::Slot")]

    def stop(self):
        """End all of it."""
        while self.nodes:
            self.kill_node()
        for process in psutil.process_iter(["cmdline"]):  # of the head: some leave the process that started them
            if str(self._place) in " ".join(process.info["cmdline"] or ()):
                process.kill()
        for started in self._processes:
            started.wait()
        self._ip(f"link del {self._name}")
        self._log.close()
        shutil.rmtree(self._place, ignore_errors=True)

    def _start(self, options, inside=(), env_vars=None):
        environment = {**os.environ, "RAY_USAGE_STATS_ENABLED": "0", **(env_vars or {})}
        command = [*inside, sys.executable, "-m", "ray.scripts.scripts", "start", "--block", *options]
        return subprocess.Popen(command, env=environment, stdout=self._log, stderr=self._log)

    @staticmethod
    def _ip(words):
        return subprocess.run(["ip", *words.split()], capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="session", autouse=True)
def token():
    """Ray's clusters ask for a token; read when Ray is imported."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_AUTH_MODE", "token")
        patch.setenv("RAY_AUTH_TOKEN", secrets.token_hex(32))
        yield


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """The folder of the jobs of a Slurm cluster, in place of the user's own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "fd100-harness" / "jobs"


@pytest.fixture
def two_nodes(tmp_path, monkeypatch):
    """A cluster of two nodes that do not see the folder `hidden`; they have the toys where a test asks first."""
    pytest.importorskip("ray")
    if os.getuid() != 0 or shutil.which("ip") is None:
        pytest.skip("needs root and ip: apt-get install iproute2")
    monkeypatch.chdir(tmp_path)  # Python finds modules where it is started: here there are none
    (tmp_path / "hidden").mkdir()
    cluster = TwoNodes(tmp_path / "hidden")
    try:
        cluster.begin()
        yield cluster
    finally:
        cluster.stop()


@pytest.fixture
def that(make_cell):
    """A cell that does `then` in the end, and leaves a note."""

    def make(then, note="", seed=0):
        return make_cell(seed=seed, algorithm=Choice("wander", (("then", then), ("note", str(note))), f"then={then}"))

    return make


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
def slurm(tmp_path_factory):
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
            stack.callback(stack.enter_context(subprocess.Popen(command, stdout=log, stderr=log)).terminate)
        _wait_for_idle_node(folder / "log")
        yield


def _free_port():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        return server.getsockname()[1]


def _wait_for_idle_node(log):
    until = time.monotonic() + 30.0
    while time.monotonic() < until:
        told = subprocess.run(["sinfo", "--noheader", "--format=%t"], capture_output=True, text=True, check=False)
        if told.stdout.strip() == "idle":
            return
        time.sleep(0.5)
    pytest.fail(f"Slurm does not start: {log.read_text()[-2000:]}")
