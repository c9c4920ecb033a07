"""Trackers are told what happens to cells, each number once, and none of them costs a cell."""

import threading
import time
from dataclasses import dataclass, field

import pytest

from harness.errors import PluginError
from harness.executor import Event
from harness.experiment.followed import Trackers, Tracking, build_trackers, tracked_cell
from harness.record.cell import Running
from harness.registry import Choice
from tests.refusals import refused

NUMBERS = {"Training/Success Rate": 0.5}


@dataclass(frozen=True)
class Notes:
    """A tracker that keeps what it is told."""

    told: list[tuple] = field(default_factory=list)

    def why_not(self):
        """It can."""
        return ""

    def begin(self, cell):
        """Note it."""
        self.told.append(("begin", cell.id))
        return Note(self.told, cell.id)


@dataclass(frozen=True)
class Note:
    """Of one cell."""

    told: list[tuple]
    id: str

    def log(self, steps, scalars):
        """Note it."""
        self.told.append(("log", self.id, steps))

    def end(self, outcome, reason):
        """Note it."""
        self.told.append(("end", self.id, outcome, reason))


class Rig:
    """A run with a tracker that keeps notes, its clock and its complaints."""

    def __init__(self, folder, left=None, tracker=None):
        self.notes, self.troubles, self.now = Notes(), [], 1000.0
        self.trackers = Trackers({"notes": tracker or self.notes}, self.troubles.append, within=5.0)
        self.tracking = Tracking(self.trackers, folder, left or {}, lambda: self.now)
        self.running = Running(1000.0)

    def hear(self, cell, steps, scalars=NUMBERS):
        """A word of a cell."""
        self.running = self.tracking.hear(Event("progress", cell, steps, scalars=scalars), self.running)

    def told(self):
        """All that was told by the end."""
        self.tracking.pass_on()
        self.tracking.close()
        return [(kind, *rest) for kind, _, *rest in self.notes.told]


@pytest.fixture
def rig(tmp_path):
    """Nothing was left by a run before."""
    return Rig(tmp_path)


def test_a_cell_is_told_from_its_beginning_to_its_end(rig, make_cell):
    """Its numbers in between."""
    cell = make_cell()
    rig.hear(cell, 0, {})
    rig.hear(cell, 100)
    rig.tracking.pass_on()
    rig.tracking.end(cell, "failed", "the arm fell off")
    assert rig.told() == [("begin",), ("log", 100), ("end", "failed", "the arm fell off")]


def test_a_cell_that_said_nothing_is_told_too(rig, make_cell):
    """As one whose process died at once."""
    rig.tracking.end(make_cell(), "failed", "its process was ended by SIGKILL")
    assert rig.told() == [("begin",), ("end", "failed", "its process was ended by SIGKILL")]


def test_an_interrupted_cell_ends(rig, make_cell):
    """When the run does."""
    rig.hear(make_cell(), 100)
    assert rig.told() == [("begin",), ("log", 100), ("end", "interrupted", "")]


def test_nothing_is_told_before_it_is_written_down(rig, make_cell):
    """So that a kill between the two loses a number, and doubles none."""
    rig.hear(make_cell(), 100)
    assert rig.running.tracked == 100
    rig.trackers.close()
    assert [kind for kind, *_ in rig.notes.told] == ["begin"]


def test_a_killed_cell_goes_on_under_its_id(make_cell, tmp_path):
    """What was told before the kill is not told again."""
    cell, first = make_cell(), Rig(tmp_path)
    first.hear(cell, 0, {})
    for steps in (100, 200, 300):
        first.hear(cell, steps)
    first.told()
    second = Rig(tmp_path, left={cell.id: first.running})
    second.now = 2000.0
    second.hear(cell, 150, {})  # where its checkpoint is
    for steps in (200, 300, 400):
        second.hear(cell, steps)
    assert [steps for kind, *steps in second.told() if kind == "log"] == [[400]]
    assert second.notes.told[0] == first.notes.told[0]


def test_a_cell_that_starts_over_is_a_new_one(make_cell, tmp_path):
    """Its numbers may be others: perhaps a plugin has changed since."""
    cell = make_cell()
    rig = Rig(tmp_path, left={cell.id: Running(900.0, 300, 950.0, track=900.0, tracked=300)})
    rig.hear(cell, 0, {})
    rig.hear(cell, 100)
    assert ("log", 100) in rig.told()
    assert rig.notes.told[0] != ("begin", tracked_cell(cell, 900.0, tmp_path).id)


def test_a_cell_whose_node_was_lost_repeats_nothing(rig, make_cell):
    """It goes on from its checkpoint on another machine, within the same run."""
    cell = make_cell()
    for steps, scalars in ((0, {}), (100, NUMBERS), (200, NUMBERS), (100, {}), (150, NUMBERS), (250, NUMBERS)):
        rig.hear(cell, steps, scalars)
    assert [steps for kind, *steps in rig.told() if kind == "log"] == [[100], [200], [250]]


def test_one_that_raises_is_switched_off_and_the_others_are_told(make_cell, tmp_path):
    """It is named once, with what it raised."""

    class Broken(Notes):
        def begin(self, cell):
            raise SystemExit("no such server")

    notes, troubles = Notes(), []
    trackers = Trackers({"broken": Broken(), "notes": notes}, troubles.append, within=5.0)
    for number in range(3):
        trackers.begin(tracked_cell(make_cell(seed=number), 0.0, tmp_path))
    trackers.close()
    assert troubles == ["tracker 'broken' is switched off, the cells go on: SystemExit: no such server"]
    assert len(notes.told) == 3


def test_one_that_hangs_holds_nobody_up(make_cell, tmp_path):
    """The run ends without it."""
    forever = threading.Event()

    class Hanging(Notes):
        def begin(self, cell):
            forever.wait()

    troubles = []
    trackers = Trackers({"slow": Hanging()}, troubles.append, within=0.05)
    begun = time.monotonic()
    trackers.begin(tracked_cell(make_cell(), 0.0, tmp_path))
    trackers.close()
    forever.set()
    assert time.monotonic() - begun < 5.0
    assert troubles == ["tracker 'slow' is switched off, the cells go on: it has not finished within 0.05 s"]


def test_a_cell_is_told_with_all_its_parameters(make_cell, tmp_path):
    """Those of its plugins by kind and name; the same cell done again has another id."""
    cell = make_cell(reward=Choice("arp", (("k1", 2.0), ("k2", 1.5)), "arp:k1=2"))
    told = tracked_cell(cell, 1000.0, tmp_path)
    assert told.config["reward.k1"] == 2.0
    assert (told.config["seed"], told.config["simulator"], told.config["cell"]) == (0, "ideal", cell.id)
    assert told.group == "ideal · wander · arp:k1=2 · fd100-reach:horizon=5"
    assert told.id.startswith(cell.id)
    assert len(told.id) <= 28
    assert told.id != tracked_cell(cell, 1001.0, tmp_path).id


def test_trackers_are_built_from_text_tables_and_lists(toys):
    """Each once."""
    built = build_trackers(["tensorboard,clumsy:mood=fine", {"name": "tensorboard"}], toys)
    assert list(built) == ["tensorboard", "clumsy:mood=fine"]
    assert build_trackers((), toys) == {}


def test_one_that_cannot_be_used_is_refused(toys):
    """With its own reason."""
    with refused("Tracker 'clumsy:mood=bad' cannot be used: not now"):
        build_trackers("clumsy:mood=bad", toys)


def test_one_that_cannot_even_say_so_is_named(toys, monkeypatch):
    """Instead of a traceback."""
    monkeypatch.delattr(toys.get("trackers", "clumsy").load(), "why_not")
    with pytest.raises(PluginError, match=r"of package toy-arm 1\.0 has no why_not"):
        build_trackers("clumsy", toys)
