"""Sequences that hold, and cells that are rare."""

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.kept import Cells
from harness_plugins.audit.search.moves import Feedback, draw_feedback, moves_in

NUMBERS = moves_in(Box(-2.0, 2.0, (1,)))


def walk(held, begin):
    """Where a thing that falls away from 0 goes, and what was done: x' = 1.1 x + u."""
    at, way, taken = np.array([begin]), [begin], []
    policy = held.after(np.full((60, 1), 0.05), NUMBERS, np.asarray)
    for _ in range(60):
        taken.append(policy(at))
        at = 1.1 * at + taken[-1]
        way.append(float(at[0]))
    return np.array(way), np.array(taken)


def test_what_falls_over_is_held():
    """From step 5 on it stays near where it was then; the same actions without feedback fall away."""
    way, taken = walk(Feedback(5, np.array([-0.05]), np.array([[-0.4]])), 0.1)
    assert (taken[:5] == 0.05).all()
    assert np.abs(way[6:] - way[5]).max() < 0.1
    fallen, _ = walk(Feedback(99, np.zeros(1), np.zeros((1, 1))), 0.1)
    assert fallen[-1] > 50.0


def test_choices_are_held_too():
    """The choice that is liked most is taken."""
    held = Feedback(0, np.zeros(3), np.array([[1.0], [0.0], [-1.0]]))
    act = held.after(np.zeros(9, int), moves_in(Discrete(3, start=4)), np.asarray)
    assert [int(act(np.array([at]))) for at in (0.5, 2.0, 0.0)] == [4, 4, 6]


def test_drawn_and_changed_ones_are_within_bounds():
    """They begin in the episode; half of the gains are 0; a change keeps the shape."""
    rng = default_rng(0)
    for moves in (NUMBERS, moves_in(Discrete(3))):
        drawn = [draw_feedback(rng, moves, np.array([1.0, 0.1]), 7) for _ in range(200)]
        gains = np.stack([it.gains for it in drawn])
        assert 0.4 < (gains == 0.0).mean() < 0.6
        assert all(it.step >= 0 and it.gains.shape == gains.shape[1:] for it in [it.changed(rng, 3) for it in drawn])


def test_the_shortest_way_to_a_cell_is_kept_and_rare_cells_are_drawn_more():
    """One cell is crossed by a hundred episodes, another by one."""
    cells = Cells(Box(0.0, 1.0, (1,)))
    for k in range(100):
        cells.add(np.array([[0.05], [0.05], [0.15]]), np.array([k]))
    cells.add(np.array([[0.05], [0.15], [0.95]]), np.array([777]))
    ways = cells.draw(default_rng(0), 3_000)
    steps, rare = np.array([way.length for way in ways]), np.array([way.genes[0] == 777 for way in ways])
    assert len(cells.ways) == 3
    assert (set(steps[rare]), set(steps[~rare])) == ({1, 2}, {0})
    assert (steps == 2).mean() > 0.7


def test_boxes_and_choices_are_written_and_played_again():
    """Inside any box, with open bounds too; what is written and played is the same again."""
    box = Box(np.array([-2.0, 0.0, -np.inf]), np.array([2.0, 1.0, np.inf]), dtype=np.float64)
    moves, rng = moves_in(box), default_rng(0)
    for genes in (moves.white(rng, 5, 9), moves.coloured(rng, 5, 9)):
        played = moves.played(genes)
        assert all(box.contains(action.astype(np.float64)) for action in played.reshape(-1, 3))
        assert np.allclose(moves.written(played), genes, atol=1e-6)
    choices = moves_in(Discrete(3, start=5))
    assert set(np.unique(choices.played(choices.coloured(rng, 50, 20)))) == {5, 6, 7}
