"""A recording is read part by part: what is checked across parts, and how several recorders become one log."""

from dataclasses import replace

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.log import in_memory
from harness.record import TrainingFacts, read_recording
from harness.record.recording.facts import ActionFacts, Source
from harness.record.recording.recording_writer import RecordingWriter
from harness.record.recording.scores import write_scores
from tests.record.recording.told import change_first

FACTS = TrainingFacts(rewards=("v1",), trained_with="v1", num_envs=2)
ROWS = 7
"""Of a part."""
pytestmark = pytest.mark.usefixtures("small_parts")


def _write(folder, number, ticks):
    """The steps of a recorder of two envs, in one long episode each; tick, env and pay of each."""
    draw = np.random.default_rng(number)
    steps = [(tick, env, float(draw.normal())) for tick in ticks for env in range(2)]
    order = {tick: place for place, tick in enumerate(ticks)}
    writer = RecordingWriter(folder, FACTS, number=number)
    writer.append([[tick, env, 0, order[tick], paid, False, False] for tick, env, paid in steps])
    writer.close()
    return steps


TICKS = {
    "as many of all": [[*range(20)]] * 3,
    "one ended early": [[*range(20)], [0, 1], [*range(9)]],
    "one has none": [[*range(9)], [], [3, 4, 5]],
    "one begins late": [[*range(5)], [*range(30, 44)], [*range(12)]],
}


@pytest.mark.parametrize("case", TICKS)
def test_steps_of_several_recorders_stand_in_the_order_of_time(tmp_path, case):
    """Those of a moment by env, whatever part they lie in, as sorting all of them at once would have it."""
    steps = [
        (tick, 2 * number + env, paid)
        for number, ticks in enumerate(TICKS[case])
        for tick, env, paid in _write(tmp_path, number, ticks)
    ]
    rows = read_recording(tmp_path).rows(["tick", "env", "reward/v1", "time"])
    found = list(zip(*(rows[name].tolist() for name in ("tick", "env", "reward/v1")), strict=True))
    assert found == sorted(steps)
    assert rows["time"].tolist() == [*range(1, len(steps) + 1)]


def test_scores_of_several_recorders_follow_their_steps(tmp_path):
    """What was paid later stands in the row that it was paid for."""
    for number in range(2):
        steps = _write(tmp_path, number, [*range(9)])
        paid = np.array([100 * number + 10 * tick + env for tick, env, _ in steps], float)
        facts = TrainingFacts(rewards=("later",), trained_with="", sources={"reward/later": Source("", "later")})
        write_scores(tmp_path / f"scores-{number}.parquet", in_memory(facts, {"reward/later": paid}))
    rows = read_recording(tmp_path).rows(["tick", "env", "reward/later"])
    expected = 100 * (rows["env"] // 2) + 10 * rows["tick"] + rows["env"] % 2
    assert rows["reward/later"].tolist() == expected.tolist()


def test_parts_are_read_one_at_a_time(tmp_path):
    """The second one when somebody asks for its rows: only then is it found to be none."""
    _write(tmp_path, 0, [*range(20)])
    pieces = read_recording(tmp_path).pieces(["reward/v1"], ROWS)
    (tmp_path / "steps-0-00001.parquet").write_bytes(b"")
    assert len(next(pieces)) == ROWS
    with pytest.raises(SchemaError, match="steps-0-00001"):
        next(pieces)


@pytest.mark.parametrize(("column", "value"), [("step", 9), ("episode", 3), ("time", 0)])
def test_step_that_does_not_follow_the_part_before_is_refused(tmp_path, column, value):
    """In the first row of an env in a later part."""
    _write(tmp_path, 0, [*range(20)])
    change_first(tmp_path / "steps-0-00002.parquet", column, value)
    with pytest.raises(SchemaError, match=r"does not follow|order of time"):
        read_recording(tmp_path).rows(["reward/v1"])


def test_actions_have_their_shape(tmp_path):
    """And are left out where they cannot be taken again: zeros stand in their place then."""
    for name, problem in (("whole", ""), ("broken", "its env was reset with options")):
        facts = replace(FACTS, num_envs=1, actions=ActionFacts((2, 1), "float32", problem))
        writer = RecordingWriter(tmp_path / name, facts)
        writer.append([[0, 0, 0, 0, 1.0, False, False, 5, 0, -1, 0.25, 0.5]])
        writer.close()
    whole, broken = (read_recording(tmp_path / name) for name in ("whole", "broken"))
    assert whole["action"].tolist() == [[[0.25], [0.5]]]
    assert (whole["seed"].tolist(), whole["resets"].tolist(), whole["answer"].tolist()) == ([5], [0], [-1])
    assert not {"action", "seed", "resets", "answer"} & {*broken.names}


def test_reward_whose_name_has_a_slash_is_no_term(tmp_path):
    """Names of rewards of other packages have one."""
    facts = TrainingFacts(rewards=("mine/calm", "own"), trained_with="own", terms={"mine/calm": ("effort",)})
    writer = RecordingWriter(tmp_path, facts)
    writer.append([[0, 0, 0, 0, 1.0, 2.0, 1.0, True, False]])
    writer.close()
    log = read_recording(tmp_path)
    assert (log.rewards, log.terms_of("mine/calm")) == (("mine/calm", "own"), ("effort",))
    assert (log["reward/mine/calm"][0], log["reward/own"][0], log["reward/mine/calm/effort"][0]) == (1.0, 2.0, 1.0)


def test_reward_and_term_of_one_column_are_refused(tmp_path):
    """Two numbers of one name would be mixed."""
    facts = TrainingFacts(rewards=("a", "a/b"), trained_with="a", terms={"a": ("b",)})
    RecordingWriter(tmp_path, facts).close()
    with pytest.raises(SchemaError, match="have the same column"):
        read_recording(tmp_path)
