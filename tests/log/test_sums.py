"""What an episode is paid in all, whoever asks: results, audits, the live page, and a run's own numbers."""

from dataclasses import replace
from math import fsum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.experiment.arm_world import LearningSoFar
from harness.log import LogFacts, in_memory
from harness.log.log import (
    EPISODES,
    OpenEpisodes,
    episode_sum,
    episode_sums,
    sums_so_far,
)
from harness.payoff.rollout import discounted_sum
from harness.record import COLUMN, SCALARS
from harness.record.progress import RETURN
from harness.record.trace import PAID, mean_return
from harness.results.by_term import by_term
from harness.results.recordings.episodes import episodes_of
from tests.plugins.audit.search.certified import certificate_of

TERMS = ("near", "effort")
PAYS = st.floats(-1e3, 1e3, allow_subnormal=False)


@st.composite
def trainings(draw):
    """Steps of some envs, their episodes of any lengths, the last one of an env maybe cut off; what both terms paid."""
    lengths = draw(st.lists(st.lists(st.integers(1, 9), min_size=1, max_size=4), min_size=1, max_size=3))
    order = draw(st.permutations([env for env, of in enumerate(lengths) for _ in range(sum(of))]))
    episode = [np.repeat(np.arange(len(of)), of).tolist() for of in lengths]
    ends = [np.concatenate([np.arange(size) == size - 1 for size in of]).tolist() for of in lengths]
    if len(lengths[-1]) > 1 and draw(st.booleans()):
        ends[-1][-1] = False
    columns = {
        "env": np.array(order),
        "episode": np.array([episode[env].pop(0) for env in order]),
        "terminated": np.array([ends[env].pop(0) for env in order]),
    }
    columns["truncated"] = columns["terminated"] & draw(st.booleans())
    paid = draw(st.lists(st.tuples(PAYS, PAYS), min_size=len(order), max_size=len(order)))
    pays = dict(zip(TERMS, np.array(paid).T, strict=True))
    told = {"reward/own": pays["near"] + pays["effort"], **{f"reward/own/{name}": of for name, of in pays.items()}}
    return in_memory(LogFacts(path=Path("steps"), format="steps"), {**columns, **told})


def in_the_order_of_their_ends(log):
    """The rows of each episode."""
    return sorted(log.episodes, key=lambda rows: rows[-1])


def by_rows(log, column, discount):
    """By the numbers of their rows, as results ask."""
    return episode_sums(log[column], in_the_order_of_their_ends(log), discount)


def alone(log, column, discount):
    """Each alone, as a search asks."""
    return [episode_sum(log[column][rows], discount) for rows in in_the_order_of_their_ends(log)]


def side_by_side(log, column, discount):
    """All at once, those that ended are paid nothing, as scripted movements ask."""
    episodes = in_the_order_of_their_ends(log)
    paid = np.zeros((max(map(len, episodes)), len(episodes)))
    for place, rows in enumerate(episodes):
        paid[: len(rows), place] = log[column][rows]
    return discounted_sum(paid, discount)


def piece_by_piece(log, column, discount):
    """In pieces of any length, as the live page and a run's own numbers ask."""
    told = []
    for size in (1, 7):
        going = OpenEpisodes.none(1)
        told.append([])
        for begin in range(0, len(log), size):
            steps = log.part(slice(begin, begin + size))
            going, _, sums = going.after(steps["env"], steps["episode"], steps["terminated"], [steps[column]])
            told[-1] += sums[0].tolist()
    assert told[0] == told[1]
    return told[0]


def step_by_step(log, column, discount):
    """The last of the sums so far, as pages of an episode draw."""
    return [sums_so_far(log[column][rows])[-1] for rows in in_the_order_of_their_ends(log)]


def learned(log, column, discount):
    """As a training in an environment tells, and an arm's: the mean."""
    rows, learning = np.zeros((len(log), len(SCALARS))), LearningSoFar([])
    for name, values in {"reward": log[column], **log.rows(EPISODES).columns}.items():
        rows[:, COLUMN[name]] = values
    learning.append(rows)
    return np.full(len(log.episodes), learning.means()[RETURN])


def recorded(log, column, discount):
    """As a report of recordings and logs asks."""
    return episodes_of(log).returns["own"]


def of_a_trace(log, column, discount):
    """As a report of an arm asks, and the trackers of its evaluations: the mean."""
    return np.full(len(log.episodes), mean_return(log.add({name: log[column] / len(PAID) for name in PAID})))


def by_its_terms(log, column, discount):
    """As a report of terms asks: the mean."""
    return np.full(len(log.episodes), by_term({"it": log[column]}, log.episodes, len(log)).terms["it"].whole)


def certified(log, column, discount):
    """As a certificate tells it."""
    made = certificate_of()
    place = replace(made.place, gamma=discount)
    paid = (log[column][rows] for rows in in_the_order_of_their_ends(log))
    return [replace(made, place=place, shown=replace(made.shown, paid=of)).discounted for of in paid]


DOORS = {
    "any term, discounted or not": (by_rows, alone, side_by_side, certified),
    "any term": (piece_by_piece, step_by_step, of_a_trace, by_its_terms, learned),
    "the reward": (recorded,),
}


@pytest.mark.parametrize(("asked", "door"), [(asked, door) for asked, of in DOORS.items() for door in of])
@given(log=trainings(), discount=st.sampled_from([1.0, 0.99, 0.5]), term=st.sampled_from(["", *TERMS]))
def test_every_door_tells_the_same_sum(asked, door, log, discount, term):
    """That of exact arithmetic; where a door tells means, the mean."""
    discount = discount if "discounted" in asked else 1.0
    column = "reward/own" if not term or asked == "the reward" else f"reward/own/{term}"
    steps = [log[column][rows] for rows in in_the_order_of_their_ends(log)]
    exact = [fsum(paid * discount**t for t, paid in enumerate(of.tolist())) for of in steps]
    told = door(log, column, discount)
    size = 1e-12 * max(1.0, *(np.abs(of).sum() for of in steps))
    exact = np.full(len(exact), np.mean(exact)) if door in (of_a_trace, by_its_terms, learned) else exact
    assert told == pytest.approx(exact, rel=1e-12, abs=size)


def test_a_sum_has_the_bits_of_its_episode_alone():
    """Whatever stands before it, also of steps that pay minus zero."""
    values = np.append(np.random.default_rng(1).normal(size=(990,)), [-0.0] * 10)
    episodes = [*np.split(np.random.default_rng(2).permutation(990), [1, 9, 300]), np.arange(990, 1000)]
    assert repr(episode_sums(values, episodes).tolist()) == repr([float(values[rows].sum()) for rows in episodes])
