"""Films of policies in an environment: their evaluations, played again."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from harness import load_registry, load_results
from harness.cli import main
from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.registry import read_given
from harness_plugins.video.environment_film import box_of, environment_film
from harness_plugins.video.film import HEIGHT, HELD, WIDTH
from tests.refusals import refused
from tests.stores import create_store

TOY = str(Path(__file__).parents[2] / "experiment" / "environments" / "toy.py")


def run_some(folder, cells, **keys):
    """An experiment of two rewards and one seed, in an env that draws a point on a line: so many cells are done."""
    given = read_given([TOY])
    asked = {"task": "toy", "algo": "random", "seeds": 1, "steps": 16, "evaluation_episodes": 2, **keys}
    plan = expand(check_experiment(asked), load_registry(given=given))
    store = create_store(folder, plan)
    for cell in plan.cells[:cells]:
        assert run_cell(cell, store.cell_folder(cell), lambda word: None, CellOptions(plugins=given)).status == "done"
    return load_results(folder, plugins=[TOY])


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Both cells are done."""
    return run_some(tmp_path_factory.mktemp("toy") / "experiment", 2)


@pytest.fixture
def line(results, monkeypatch):
    """What makes an env of the toy's in this test."""
    toy = results.registry.get("environments", "toy").load()
    return monkeypatch, toy, type(toy().make())


def test_baseline_and_proposed_reward_stand_beside_one_another(results):
    """Both play the episodes of their evaluations, from the first on; the end of each is held."""
    frames = list(environment_film(results, [], 2))
    assert frames[0].image.width == 360
    assert [frame.seconds for frame in frames].count(HELD) == 2
    assert (np.asarray(frames[0].image) != np.asarray(frames[-1].image)).any()


def test_the_command_films_an_environment_too(results, tmp_path):
    """As it films arms."""
    film = tmp_path / "a.gif"
    with pytest.raises(SystemExit) as ended:
        main(["video", str(results.folder), "--plugin", TOY, "--episodes", "1", "--out", str(film)])
    assert not ended.value.code
    assert film.read_bytes().startswith(b"GIF8")


def test_a_baseline_without_another_reward_is_shown_alone(tmp_path):
    """As in an experiment that goes on."""
    (frame, *_) = environment_film(run_some(tmp_path / "experiment", 1), [], 1)
    assert frame.image.width == 180


def test_where_no_cell_is_done_there_is_nothing_to_show(tmp_path):
    """It is told by the folder."""
    with refused("has nothing to show: no cell is done"):
        list(environment_film(run_some(tmp_path / "experiment", 0), [], 1))


def test_a_named_cell_is_shown_alone(results):
    """By how its id begins."""
    (frame, *_) = environment_film(results, [results.done[1].cell.id[:6]], 1)
    assert frame.image.width == 180


def test_an_episode_that_goes_another_way_is_refused(results, line):
    """As it does where another version of the environment is installed; nothing false is shown."""
    patch, _, env = line
    step = env.step
    patch.setattr(env, "step", lambda self, action: (*step(self, action)[:2], True, False, {}))
    with refused(r"takes 1 here\. Is another version"):
        list(environment_film(results, [], 1))


def test_an_env_that_draws_no_arrays_is_refused(results, line):
    """In one line that names the mode."""
    patch, _, env = line
    patch.setattr(env, "metadata", {"render_modes": ["human"]})
    with refused("has no render mode 'rgb_array'"):
        list(environment_film(results, [], 1))


def test_a_missing_renderer_is_told_in_one_line(results, line):
    """With what can be done."""
    patch, _, env = line

    def render(self):
        raise ImportError("no OpenGL\nhere")

    patch.setattr(env, "render", render)
    with refused(r"toy cannot draw here: no OpenGL here\. Without a screen set MUJOCO_GL=egl"):
        list(environment_film(results, [], 1))


def test_an_env_that_draws_nothing_is_told(results, line):
    """And no film is written."""
    patch, _, env = line
    patch.setattr(env, "render", lambda self: None)
    with refused("draws no picture"):
        list(environment_film(results, [], 1))


def test_an_episode_that_was_cut_is_shown(tmp_path):
    """As far as it was recorded."""
    results = run_some(tmp_path / "experiment", 1, task="toy:endless=true", evaluation_horizon=6)
    assert list(environment_film(results, [], 1))[-1].seconds == HELD


def dot(x, y, size=(400, 300)):
    """A picture of a small square."""
    picture = Image.new("RGB", size, "#445544")
    picture.paste("#ffffff", (x, y, x + 10, y + 10))
    return picture


def test_pictures_are_cropped_to_what_moves():
    """With some air, in the shape of a film's picture."""
    left, top, right, bottom = box_of([dot(100, 100), dot(180, 110)])
    assert (left < 100, top < 100, right > 190, bottom > 120) == (True,) * 4
    assert right - left < 200
    assert (right - left) / (bottom - top) == pytest.approx(WIDTH / HEIGHT, rel=0.03)


@pytest.mark.parametrize("x", [0, 390])
def test_the_part_lies_within_the_picture(x):
    """Where the edge is near, it is moved."""
    left, top, right, bottom = box_of([dot(x, 0), dot(x, 20)])
    assert (left >= 0, top >= 0, right <= 400, bottom <= 300) == (True,) * 4
    assert left <= x < right


def test_pictures_in_which_nothing_moves_stay_whole():
    """As do those of two sizes."""
    assert box_of([dot(5, 5), dot(5, 5)]) is None
    assert box_of([dot(5, 5), dot(5, 5, (200, 300))]) is None
