"""How much of each room the tests run."""

import json

import pytest

from tests.rooms_covered import CLUSTERS, LIBRARIES, main, room_of, rooms_of


def told(branches, run):
    """What coverage.py tells of a file."""
    counts = {"num_branches": branches, "covered_branches": run, "num_statements": 2 * branches}
    return {"summary": {**counts, "covered_lines": 2 * run}}


@pytest.fixture
def report(tmp_path):
    """A file as coverage.py writes it: one room is well tested, one is not."""
    files = {
        "harness/eta/curve.py": told(10, 9),
        "harness/eta/word.py": told(10, 10),
        "plugins/tasks/low.py": told(4, 3),
    }
    path = tmp_path / "coverage.json"
    path.write_text(json.dumps({"files": files}))
    return str(path)


def test_a_room_that_falls_short_is_named(report, capsys):
    """Status 1; the shares are those of the room's files together."""
    assert main(report) == 1
    header, eta, tasks, last = capsys.readouterr().out.splitlines()
    assert header.split() == ["room", "branches", "run", "lines", "run"]
    assert eta.split() == ["harness/eta", "20", "95.0", "%", "40", "95.0", "%"]
    assert tasks.split()[:3] == ["plugins/tasks", "4", "75.0"]
    assert last.startswith("Below 90 % of the branches: plugins/tasks. ")


@pytest.mark.parametrize("tests", ["tests/eta", "tests/eta/"])
def test_the_tests_of_a_room_count_for_that_room_alone(report, capsys, tests):
    """They run little of the others."""
    assert main(report, tests) == 0
    assert "plugins/tasks" not in capsys.readouterr().out


def test_the_tests_of_a_plugins_room_count_for_it(report, capsys):
    """It stands one folder deeper."""
    assert main(report, "tests/plugins/tasks") == 1
    assert "harness/eta" not in capsys.readouterr().out


def test_rooms_are_folders():
    """Whatever is deeper belongs to them; flat modules are a room of their own."""
    assert room_of("harness/report/page/curves.py") == "harness/report"
    assert room_of("harness/task.py") == "harness"
    assert room_of("plugins/rewards/arp.py") == "plugins/rewards"


def test_what_cannot_be_run_does_not_count():
    """A file without its library, and what a cluster runs; with the library it counts."""
    files = {"plugins/simulators/drake.py": told(8, 0), "plugins/slurm_array/array.py": told(8, 0)}
    assert rooms_of(files, []) == []
    assert [room.name for room in rooms_of(files, ["pydrake"])] == ["plugins/simulators"]


def test_files_and_rooms_that_are_left_out_are_there(pytestconfig):
    """A name that is left behind would leave out nothing, or the wrong file."""
    for path in (*LIBRARIES, *CLUSTERS):
        assert (pytestconfig.rootpath / path).exists()


def test_a_room_without_branches_is_whole(tmp_path, capsys):
    """There is nothing that could be missing."""
    path = tmp_path / "coverage.json"
    path.write_text(json.dumps({"files": {"plugins/tasks/low.py": told(0, 0)}}))
    assert main(str(path)) == 0
    assert "100.0 %" in capsys.readouterr().out
