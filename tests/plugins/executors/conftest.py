"""A Ray cluster of two nodes on this machine."""

from collections.abc import Iterator
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
