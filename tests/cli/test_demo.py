"""``harness demo`` as a newcomer types it."""

import shutil
import subprocess
import sys

from numpy.testing import assert_array_equal

from harness import load_results
from harness.results.replay import shows_of


def test_the_number_grows_and_the_arm_moves_the_same(harness, tmp_path):
    """Every recorded step is alike, pay grows 1.5 times, all by the ruler; the experiment stays where it was put."""
    answer = harness("demo --out mine")
    assert (answer.status, answer.err) == (0, "")
    told = " ".join(answer.out.split())
    assert "is paid 1.50 times as much" in told
    same, recorded = told.partition("In ")[2].partition(" recorded")[0].split(" of ")
    assert same == recorded != "0"
    results = load_results(tmp_path / "mine")
    (combination,) = results.combinations
    split = combination.number.pay.ratio
    assert (round(split.ruler.value, 9), round(split.behaviour.value, 9)) == (1.5, 1.0)
    assert "harness report mine --details" in answer.out
    (show,) = shows_of(results)
    baseline, proposed = (side.episodes for side in show.sides)
    assert max(len(episode.steps) for episode in baseline) >= 20  # long enough to be watched
    for one, other in zip(baseline, proposed, strict=True):
        assert_array_equal(one.qpos, other.qpos)
    assert 'id="replay-player"' in (tmp_path / "mine" / "report.html").read_text()


def test_python_m_harness_is_the_command_line():
    """For who has no scripts on the path."""
    told = subprocess.run([sys.executable, "-m", "harness", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout.count(".") == 2


def test_the_demo_says_no_difference(harness):
    """All steps are the same: that is known, and not for chance to tell."""
    out = harness("demo --out mine").out
    assert "arp  NO DIFFERENCE" in out
    assert "CANNOT TELL " not in out.partition("NO DIFFERENCE stands there")[0]


def test_a_demo_that_was_killed_goes_on(harness, tmp_path):
    """The same command does what is missing, and says the same; cells that were done stay."""
    first = harness("demo --out mine")
    gone, *kept = sorted((tmp_path / "mine/cells").iterdir())
    shutil.rmtree(gone)
    (tmp_path / "mine/report.html").unlink()
    before = [path.stat().st_ino for path in kept]
    assert harness("demo --out mine") == first
    assert [path.stat().st_ino for path in kept] == before
    assert gone.is_dir()


def test_the_demo_joins_no_other_experiment(harness, finished):
    """One of the user is left as it is."""
    answer = harness("demo --out", finished(seeds=1))
    assert answer.status == 2
    assert "holds another experiment" in answer.err
