"""What is checked, opened in this process."""

import pytest

from harness_plugins.kit.inspection.finding import Asked, read_plugins
from harness_plugins.kit.inspection.subject import open_subject, run_check

SOURCE = """
from dataclasses import dataclass
{top}

@dataclass(frozen=True)
class Mine:
    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        return carry, {value}
"""


@pytest.fixture
def opened(tmp_path):
    """Opens a reward in a file, whose module begins with `top` and which pays `value`."""

    def open_reward(top="", value="-sample.distance", name="mine"):
        (tmp_path / "mine.py").write_text(SOURCE.format(top=top, value=value))
        files, _ = read_plugins([str(tmp_path / "mine.py")])
        return open_subject(Asked(name, files=files), tmp_path / "notes.txt")

    return open_reward


def test_notes_tell_what_is_done(opened, tmp_path):
    """If that ends the process, they are what is left."""
    opened()
    assert (tmp_path / "notes.txt").read_text() == "reward 'mine' was imported and built"


def test_file_that_cannot_be_imported_is_a_finding(opened):
    """There are no checks then."""
    subject = opened(top="raise ValueError('no licence')")
    (finding,) = subject.outline.findings
    assert (finding.check, finding.verdict) == ("target", "error")
    assert "no licence" in finding.sentence
    assert subject.checks == ()


def test_import_that_leaves_is_a_finding(opened):
    """`sys.exit` at the top of a file is held."""
    (finding,) = opened(top="raise SystemExit(0)").outline.findings
    assert finding.verdict == "error"
    assert "SystemExit" in finding.sentence


def test_check_of_what_cannot_be_built_any_more_fails(opened):
    """A plugin may work in the first process, and not in the one that replaced it."""
    finding = run_check(opened(top="raise ValueError('only once')"), "reward-finite-edges")
    assert finding.verdict == "error"
    assert "could be built before, and now it cannot" in finding.sentence
    assert "only once" in finding.sentence
