"""Pictures of an evaluation episode, for the page."""

import io
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from harness import load_results, run
from harness.experiment.environments.frames import draw_frames
from harness.experiment.verify import verify
from harness.files.bounded import write_keyed
from harness.report import Report, write_html
from harness.report.page.comparison import frames_of
from harness.results.frames import frames_file, made_of, read_frames

pytest.importorskip("PIL")
TOY = Path(__file__).parent / "toy.py"


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Two rewards, trained and drawn."""
    folder = tmp_path_factory.mktemp("drawn")
    found = run(task="toy", algo="random", steps=16, seeds=2, evaluation_episodes=2, jobs=1, plugins=[TOY], out=folder)
    draw_frames(found, 1)
    return folder


@pytest.fixture
def results(drawn, tmp_path):
    """A copy of them, which a test may change."""
    shutil.copytree(drawn, tmp_path / "results")
    return load_results(tmp_path / "results", plugins=[TOY])


def test_the_first_seed_of_a_comparison_is_drawn(results):
    """Under both rewards; no other cell is."""
    drawn = [cell for cell in results.done_cells if frames_file(results.folder, cell.id).is_file()]
    assert sorted((cell.reward.label, cell.seed) for cell in drawn) == [("near", 0), ("right", 0)]


def test_pictures_stand_side_by_side(results):
    """As many as there are steps to show, within the bound."""
    from PIL import Image

    found = read_frames(results.folder, results.manifest(results.done_cells[0]))
    with Image.open(io.BytesIO(found.strip)) as strip:
        assert strip.width == 160 * len(found.steps)
    assert found.steps[0] == 0
    assert 2 <= len(found.steps) <= 8
    assert len(found.strip) <= 150_000


def test_the_page_has_both_sides(results):
    """With words for those who cannot see them."""
    strips = frames_of(results, results.combinations[0])
    assert [side.title for side in strips.sides] == ["Baseline: near", "Proposed: right"]
    assert all(side.source.startswith("data:image/webp;base64,") for side in strips.sides)
    assert all("Pictures after 0, " in side.told for side in strips.sides)


def test_a_page_holds_each_picture_once(results, tmp_path):
    """The still of the first screen is cut out of it, and leads to it."""
    write_html(Report(results), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.count("data:image/webp") == 2
    for name in ("strip-1-1", "strip-1-2"):
        assert page.count(f'id="{name}"') == page.count(f'data-strip="{name}"') == 1
    assert page.count('href="#strip-1-1"') == 1


def test_kept_pictures_are_whole(results):
    """As everything that is kept of a cell."""
    assert not verify(results.folder)


def test_pictures_of_another_training_are_not_shown(results):
    """A cell that was done again has none, until they are drawn again."""
    done = results.manifest(results.done_cells[0])
    other = replace(done, files={**done.files, "policy/card.json": "0" * 64})
    assert read_frames(results.folder, other).reason.startswith("the pictures are of another training")


@pytest.mark.parametrize("content", [b"", b"[]\n", b'{"steps": "many"}\n', b"\x00\n"])
def test_what_is_not_sound_is_a_reason(results, content):
    """One line in place of the pictures; nothing else stops."""
    done = results.manifest(results.done_cells[0])
    write_keyed(frames_file(results.folder, done.cell.id), made_of(done), content)
    found = read_frames(results.folder, done)
    assert found.reason
    assert not found.strip


def test_a_damaged_file_is_no_picture(results):
    """It is drawn again by the next run."""
    done = results.manifest(results.done_cells[0])
    path = frames_file(results.folder, done.cell.id)
    path.write_bytes(path.read_bytes()[:-1])
    assert not read_frames(results.folder, done).strip
    draw_frames(results, 1)
    assert read_frames(results.folder, done).strip


def test_an_environment_that_cannot_draw_says_why(tmp_path):
    """In the place of the pictures."""
    (tmp_path / "blind.py").write_text(TOY.read_text().replace('["rgb_array"]', "[]").replace('"toy"', '"blind"'))
    found = run(
        task="blind", algo="random", steps=16, seeds=1, evaluation_episodes=2, jobs=1, plugins=[tmp_path / "blind.py"],
        out=tmp_path / "out",
    )  # fmt: skip
    draw_frames(found, 1)
    told = [side.told for side in frames_of(found, found.combinations[0]).sides]
    assert all("cannot be drawn: its env has no render mode 'rgb_array'" in line for line in told)
