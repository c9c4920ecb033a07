"""Where the files of a cluster's jobs lie, and for how long."""

import stat

import pytest

from tests.refusals import refused

PARAMETERS = {"name": "harness", "slurm_max_num_timeout": 0}


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """A folder in place of the user's own; submitit is an extra."""
    pytest.importorskip("submitit")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "fd100-harness/jobs"


def test_files_of_jobs_lie_in_a_folder_of_the_user(state):
    """Each run has its own, which nobody else reads or writes."""
    from harness_plugins.slurm_array.cluster import open_cluster

    with open_cluster("local", 1, **PARAMETERS) as first, open_cluster("local", 1, **PARAMETERS) as second:
        folders = {first.folder, second.folder}
        assert {folder.parent for folder in folders} == {state}
        assert [stat.S_IMODE(folder.stat().st_mode) for folder in (state, *folders)] == [0o700] * 3


def test_nothing_of_the_jobs_is_left(state):
    """Also where the run ends by an error."""
    from harness_plugins.slurm_array.cluster import open_cluster

    def interrupt():
        with open_cluster("local", 1, **PARAMETERS) as cluster:
            (cluster.folder / "job.pkl").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupt()
    assert list(state.iterdir()) == []


def test_no_job_is_read_from_a_folder_of_others(state):
    """It is refused before anything is submitted."""
    from harness_plugins.slurm_array.cluster import open_cluster

    state.mkdir(parents=True)
    state.chmod(0o777)
    with refused("is open to others"), open_cluster("local", 1, **PARAMETERS):
        pass
