"""The pictures of a film."""

from dataclasses import replace

import numpy as np
import pytest

from harness.results.replay import Episode, Show, Side
from harness.robot.load import load_robot
from harness.scene.scene import scene_of
from harness_plugins.video.film import FRAMES, HEIGHT, HELD, LINE, WIDTH, film_of


def episode(steps: int, outcome: str) -> Episode:
    """The FD100 turns by its first joint."""
    robot = load_robot("fd100")
    qpos = robot.home + np.linspace(0, 0.5, steps + 1)[:, None] * np.eye(6)[0]
    target = np.tile(robot.end_effector(qpos[-1]), (steps + 1, 1))
    distance = np.linalg.norm(robot.end_effector(qpos) - target, axis=1)
    return Episode(np.arange(steps + 1), qpos, target, distance, -distance, outcome, {})


@pytest.fixture(scope="module")
def show() -> Show:
    """A quick and a slow side, one episode."""
    scene = scene_of(load_robot("fd100"))
    sides = [
        Side(title, title, 0, scene, (episode(steps, outcome),), 0.1)
        for title, steps, outcome in (("one", 4, "reached"), ("other", 60, "time-out"))
    ]
    return Show("both", (7,), tuple(sides))


def test_a_film_shows_all_sides_and_holds_the_end(show: Show):
    """Its last picture is seen longest; sides stand beside one another, and fit a phone."""
    frames = list(film_of(show))
    assert 1 < len(frames) <= FRAMES
    assert frames[-1].seconds == HELD
    assert frames[0].image.width == 360
    assert (np.asarray(frames[0].image) != np.asarray(frames[-1].image)).any()


def test_a_side_that_ended_stands_still(show: Show):
    """While the other one goes on."""
    first, last = (np.asarray(frame.image)[LINE : LINE + HEIGHT] for frame in list(film_of(show))[-10:-1:8])
    np.testing.assert_array_equal(first[:, :WIDTH], last[:, :WIDTH])
    assert (first[:, WIDTH:] != last[:, WIDTH:]).any()


def test_a_third_side_stands_below(show: Show):
    """A film is never wider than two."""
    frame = next(film_of(replace(show, sides=(*show.sides, show.sides[0]))))
    alone = next(film_of(show))
    assert frame.image.width == alone.image.width
    assert frame.image.height == 2 * alone.image.height - LINE
