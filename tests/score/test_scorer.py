"""Scoring recorded runs again: exactly what was paid, whatever the pieces, for every reward there is."""

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, strategies as st

import harness.score.scorer as module
from harness.env.vector_env import ReachVectorEnv
from harness.record import TraceWriter, read_trace
from harness.record.cell_log import cell_log
from harness.record.trace import FORMAT, FORMAT_KEY
from harness.registry import choose
from harness.reward import Sample
from harness.reward.row_steps import DISTANCES, part_of
from harness.reward.terms import ROWS
from harness.robot import reach_position
from harness.score.scorer import Payer, Scorer, pay_log
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.tasks.unity import Arp2021
from tests.registered import FD100 as ROBOT, REGISTRY, UNITY_ARM as ARM

REWARDS = REGISTRY.names("rewards")
CHOICES = [*REWARDS, "arp:k1=0.3,k2=2.7", "scaled:reward=aarp,factor=0.1", "shifted:reward=(arp:k2=2),offset=-0.3"]
ENVS = 3


def reward_of(text):
    """A registered reward, its parameters at their defaults unless they are said."""
    return choose(REGISTRY, "rewards", text).build(REGISTRY, "rewards")


@cache
def record(text, simulator="ideal"):
    """The trace of a batch that partly wanders, partly makes for its targets, paid by a reward."""
    return record_under(reward_of(text), simulator)


def record_under(reward, simulator="ideal", steps=80):
    """The same for a reward that need not be registered."""
    engine = (
        IdealSimulator()
        if simulator == "ideal"
        else choose(REGISTRY, "simulators", simulator).build(REGISTRY, "simulators")
    )
    env = ReachVectorEnv(engine, ROBOT, ReachTask(horizon=15, epsilon=0.15), reward, num_envs=ENVS)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trace.parquet"
        with TraceWriter(path, 6, 6) as recorder:
            env.recorder = recorder
            drive(env, steps)
        env.close()
        return read_trace(path).load()


def drive(env, steps):
    """At random, and in all envs but the first now and then towards the target."""
    rng = np.random.default_rng(0)
    observations, _ = env.reset(seed=1)
    for step in range(steps):
        actions = rng.uniform(-1.0, 1.0, (ENVS, 6))
        if step % 5:
            offset = observations[1:, 24:27].astype(float)
            qpos = env.simulation.read().qpos[1:]
            actions[1:] = 6.0 * (offset[:, None] @ ROBOT.jacobian(qpos))[:, 0]
        observations, *_ = env.step(np.clip(actions, -1.0, 1.0).astype(np.float32))


def score(reward, trace):
    """What every row of a trace is paid."""
    return pay_log(reward, trace).total


def rows_of(trace, env=0):
    """One env's rows, in order."""
    rows = trace["env"] == env
    return {"start": trace["step"][rows] == 0, **{name: trace[name][rows] for name in DISTANCES}}


def touched(trace):
    """Where a target was reached and the episode went on to the next one."""
    return trace["reached"] & ~(trace["terminated"] | trace["truncated"])


def in_pieces(reward, rows, cuts):
    """The rows scored a piece at a time."""
    count = len(rows["start"])
    scorer, ends = Scorer(reward), sorted(min(cut, count) for cut in cuts)
    parts = zip([0, *ends], [*ends, count], strict=True)
    return np.concatenate([scorer.pay(part_of(rows, slice(*part))).total for part in parts])


# Rewards that show what they are shown


@dataclass(frozen=True)
class Shows:
    """Pays one column of its sample."""

    column: str

    def initial_carry(self, begin_distance):
        """Remembers nothing."""
        return ()

    def __call__(self, carry, sample):
        """Of a step."""
        return carry, np.asarray(getattr(sample, self.column), float)


@dataclass(frozen=True)
class Remembers:
    """Pays a mixture of its previous payment, the steps in a row that came nearer, and what it began with."""

    def initial_carry(self, begin_distance):
        """An array, and a tuple of two."""
        return np.zeros_like(begin_distance), (np.zeros_like(begin_distance), np.exp(begin_distance))

    def __call__(self, carry, sample):
        """Of a step."""
        paid, (row, began) = carry
        row = np.where(sample.delta_distance < 0.0, row + 1.0, 0.0)
        value = 0.5 * paid + row * began + sample.distance
        return (value, (row, began)), value


SCORED = {**{text: partial(reward_of, text) for text in CHOICES}, "one that remembers": Remembers}
CUTS = st.lists(st.integers(0, 200), max_size=10)


@pytest.fixture(params=SCORED, name="reward")
def _reward(request):
    return SCORED[request.param]()


# Exactly what was paid


def test_every_reward_is_scored_as_it_was_paid(subtests):
    """Bit for bit the recorded column, in a batch of envs, over many episodes."""
    for simulator in ["ideal", "mujoco"]:
        for text in CHOICES:
            with subtests.test(simulator=simulator, text=text):
                trace = record(text, simulator)
                assert trace["reached"].any()
                assert trace["truncated"].any()
                assert text == "sparse" or np.unique(trace["reward"]).size > len(trace) // 2
                np.testing.assert_array_equal(score(reward_of(text), trace), trace["reward"])


@cache
def record_tour(text):
    """The trace of arms whose episodes go on to the next target, some of them at the very place of the last one."""
    return record_tour_under(reward_of(text))


def record_tour_under(reward):
    """Decisions of three steps that jump back and forth between a few poses, in the target and outside."""
    env = ReachVectorEnv(IdealSimulator(), ARM, Arp2021(horizon=50, decision_period=3), reward, num_envs=ENVS)
    goals, reached = reach_position(
        ARM, env.task.draw_targets(ARM, np.random.default_rng(0), 1).position, ARM.home[None]
    )
    assert reached.all()
    poses = np.array([ARM.home, goals[0], goals[0] + 0.01, 0.9 * ARM.home, 0.5 * (ARM.home + goals[0])]) / ARM.upper
    rng = np.random.default_rng(3)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trace.parquet"
        with TraceWriter(path, 5, 5) as recorder:
            env.recorder = recorder
            env.reset(seed=1)
            for _ in range(80):
                env.step(poses[rng.integers(0, len(poses), ENVS)].astype(np.float32))
        return read_trace(path).load()


def test_targets_that_do_not_end_the_episode_are_scored_as_they_were_paid(tmp_path, subtests):
    """Bit for bit, though distances and memory restart inside the episode, also at the same begin distance.

    So is a recording of it, which is read a piece at a time.
    """
    path = tmp_path / "trace.parquet"
    for text in CHOICES:
        with subtests.test(text=text):
            trace = record_tour(text)
            where = np.flatnonzero(touched(trace))
            after = where[where + ENVS < len(trace)] + ENVS
            assert len(after) > 30
            assert (trace["begin_distance"][after] == trace["begin_distance"][after - ENVS]).any()
            np.testing.assert_array_equal(score(reward_of(text), trace), trace["reward"])
            names = ("env", "step", *DISTANCES, "reward", "reached", "terminated", "truncated")
            table = pa.table({name: trace[name] for name in names})
            pq.write_table(table.replace_schema_metadata({FORMAT_KEY: str(FORMAT).encode()}), path)
            log = cell_log(path)
            payer = Payer(reward_of(text), log)
            scored = [payer.pay(piece).total for piece in log.pieces(payer.columns, 37)]
            np.testing.assert_array_equal(np.concatenate(scored), trace["reward"])


def test_every_reward_scores_the_runs_of_another(subtests):
    """Runs that another reward paid get what this one would have paid for the same motion."""
    for text in CHOICES:
        with subtests.test(text=text):
            other = record("baseline")
            mine = record(text)
            np.testing.assert_array_equal(
                other["distance"], mine["distance"]
            )  # actions do not depend on the reward here
            np.testing.assert_array_equal(score(reward_of(text), other), mine["reward"])


def test_scorer_shows_a_reward_what_the_environment_shows(subtests):
    """Every column of the sample, and a carry of several parts that starts anew with each episode and each target."""
    for recording in (record_under, record_tour_under):
        for reward in [*map(Shows, Sample._fields), Remembers()]:
            with subtests.test(recording=recording.__name__, reward=reward):
                trace = recording(reward)
                np.testing.assert_array_equal(score(reward, trace), trace["reward"])


def test_start_rows_are_paid_nothing():
    """Whatever a reward pays for a distance."""
    trace = record("dense")
    scored = score(reward_of("shifted:offset=5"), trace)
    np.testing.assert_array_equal(scored == 0.0, trace["step"] == 0)


def test_trace_is_left_alone():
    """Scoring changes no column."""
    trace = record("arp")
    before = {name: column.copy() for name, column in trace.rows().columns.items()}
    score(reward_of("aarp"), trace)
    for name, column in before.items():
        np.testing.assert_array_equal(trace[name], column)


def test_envs_do_not_depend_on_one_another(subtests):
    """The rows of one env get the same alone, also if they begin inside an episode, whatever those before end with."""
    cut = record("baseline").part(slice(2 * ENVS, None))
    runs = [rows_of(cut, env) for env in range(ENVS)]
    assert not all(rows["start"][0] for rows in runs[1:])
    for reward in (*map(Shows, Sample._fields), Remembers()):
        with subtests.test(reward=reward):
            scored = score(reward, cut)
            for env, rows in enumerate(runs):
                np.testing.assert_array_equal(scored[cut["env"] == env], Scorer(reward).pay(rows).total)


def test_envs_are_scored_together():
    """Not one after the other: a reward that remembers nothing is called once for all of them."""
    trace, sizes = record("baseline"), []

    class Counts(Shows):
        def __call__(self, carry, sample):
            sizes.append(len(sample.distance))
            return super().__call__(carry, sample)

    score(Counts("distance"), trace)
    assert sizes == [ROWS, len(trace)]  # after the made-up steps that show what it reads


def test_order_of_the_rows_is_kept():
    """Rows of several envs come back where they were, also when an env's rows stand together."""
    trace = record("aarp")
    order = np.argsort(trace["env"], kind="stable")
    sorted_trace = trace.part(order)
    np.testing.assert_array_equal(score(reward_of("aarp"), sorted_trace), trace["reward"][order])


def test_trace_without_rows():
    """It has no rewards."""
    trace = record("baseline")
    empty = trace.part(slice(None, 0))
    assert score(reward_of("aarp"), empty).shape == (0,)


# A piece at a time


@given(st.sampled_from([*SCORED.values(), *(partial(Shows, column) for column in Sample._fields)]), st.booleans(), CUTS)
def test_pieces_do_not_show(build, tour, cuts):
    """However the rows are handed over, empty pieces and those that end with a touched target included, bit for bit."""
    reward, trace = build(), (record_tour if tour else record)("baseline")
    rows = rows_of(trace, 1)
    if tour:
        rows = {**rows, "touched": touched(trace)[trace["env"] == 1]}
    np.testing.assert_array_equal(in_pieces(reward, rows, [0, *cuts]), Scorer(reward).pay(rows).total)


def test_blocks_do_not_show(reward, monkeypatch):
    """Nor do rows one by one. Long pieces are scored a block at a time: how long a block is changes nothing."""
    rows = rows_of(record("baseline"), 1)
    whole = Scorer(reward).pay(rows).total
    np.testing.assert_array_equal(in_pieces(reward, rows, range(len(rows["start"]))), whole)
    monkeypatch.setattr(module, "BLOCK", 7)
    np.testing.assert_array_equal(Scorer(reward).pay(rows).total, whole)


# A target that is drawn again inside an episode


def redrawn():
    """A target is touched at the third row: in the fourth both distances belong to the next one."""
    return {
        "start": np.array([True, False, False, False, False]),
        "begin_distance": np.array([1.0, 1.0, 1.0, 2.0, 2.0]),
        "previous_best": np.array([1.0, 1.0, 0.5, 2.0, 1.75]),
        "distance": np.array([1.0, 0.5, 0.125, 1.75, 1.875]),
    }


@pytest.mark.parametrize(
    ("reward", "paid"),
    [
        (Shows("previous_distance"), [0.0, 1.0, 0.5, 2.0, 1.75]),
        (Shows("step"), [0.0, 1.0, 2.0, 3.0, 4.0]),
        (reward_of("baseline"), [0.0, 0.5, 0.875, 0.25, -0.125]),
    ],
)
def test_redrawn_target_is_paid_from_its_own_begin_distance(reward, paid):
    """The distance of the row before was to another target; the episode goes on. Pieces that meet do not show."""
    for cut in range(len(paid)):
        np.testing.assert_array_equal(in_pieces(reward, redrawn(), [cut]), paid)


def test_memory_restarts_where_the_begin_distance_changes():
    """A recording that does not say where a target was touched shows it so."""
    scored = Scorer(Remembers()).pay(redrawn()).total
    fresh = Scorer(Remembers()).pay(part_of(redrawn(), slice(3, None))).total
    np.testing.assert_array_equal(scored[3:], fresh)


def test_rows_that_begin_inside_an_episode():
    """A run whose first start row is missing begins where its first row says."""
    np.testing.assert_array_equal(
        Scorer(Shows("previous_distance")).pay(part_of(redrawn(), slice(2, None))).total, [1.0, 2.0, 1.75]
    )
    np.testing.assert_array_equal(
        Scorer(Remembers()).pay(part_of(redrawn(), slice(2, 3))).total,
        Remembers()(Remembers().initial_carry(np.array([1.0])), sample_at(redrawn(), 2))[1],
    )


def sample_at(rows, row):
    """What a reward sees at a row that nothing is known before of."""
    begin, best, distance = (rows[name][row : row + 1] for name in DISTANCES)
    return Sample(begin, best, begin, distance, distance - best, np.ones(1))


def test_a_reward_that_takes_no_made_up_steps_is_paid():
    """Compiled by JAX, it takes arrays alone, and not what notes which of them it reads."""

    class Compiled(Shows):
        def __call__(self, carry, sample):
            if not isinstance(sample, tuple):
                raise TypeError("no valid JAX type")
            return super().__call__(carry, sample)

    trace = record("baseline")
    np.testing.assert_array_equal(score(Compiled("distance"), trace), score(Shows("distance"), trace))
