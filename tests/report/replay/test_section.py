"""The replay as a part of a page."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose

from harness.record.scene import scene_from_json
from harness.report import Report, replay_of, write_html
from harness.report.replay.section import replay_data
from harness.results.replay import shows_of
from harness.robot.kinematics import end_effector_position
from harness.scene.picture import chain_of

MANY = 24
"""Combinations of a page."""


def test_joint_positions_survive_the_page(recorded):
    """To 1e-4 rad, the distance to 0.1 mm: the arm's tip is within 0.2 mm of where it was."""
    (show,) = shows_of(recorded)
    data = json.loads(json.dumps(replay_data([show])))
    told, episode = data["shows"][0]["sides"][0]["episodes"][0], show.sides[0].episodes[0]
    values = np.frombuffer(base64.b64decode(told["values"]), "<i2").reshape(len(episode.qpos), -1) * told["scales"]
    assert_allclose(values[:, :6], episode.qpos, atol=1e-4)
    assert_allclose(values[:, 6], episode.distance, atol=1e-4)
    assert_allclose(values[:, 7], episode.paid, atol=np.abs(episode.paid).max() / 32_767)
    tip = end_effector_position(chain_of(scene_from_json(data["scenes"][0])), values[:, :6])
    assert_allclose(norm(tip - episode.target, axis=1), episode.distance, atol=2e-4)


def test_an_arm_is_told_once(recorded):
    """However many sides and comparisons show it."""
    assert len(replay_data(shows_of(recorded) * 3)["scenes"]) == 1


def test_a_target_is_told_where_it_changes(recorded):
    """The first frame of each, and where it is."""
    (show,) = shows_of(recorded)
    targets = show.sides[0].episodes[0].target.copy()
    targets[5:] += 0.1
    side = show.sides[0]
    moved = replace(side, episodes=(side.episodes[0]._replace(target=targets),))
    data = replay_data([replace(show, numbers=(1,), sides=(moved,))])
    (first, then) = data["shows"][0]["sides"][0]["episodes"][0]["targets"]
    assert (first[0], then[0]) == (0, 5)
    assert_allclose(then[1:], targets[5], atol=1e-5)


def test_names_of_strangers_are_escaped(recorded):
    """A reward's name opens no tag: neither in what is seen nor in the data."""
    (show,) = shows_of(recorded)
    evil = "</script><img src=x onerror=alert(1)>"
    sides = tuple(replace(side, title=evil) for side in show.sides)
    replay = replay_of([replace(show, title=evil, sides=sides)])
    assert replay is not None
    assert "<img" not in replay.html
    assert replay.html.count("</script>") == 1


def test_nothing_is_requested(recorded):
    """No address in markup, style or script, but the name of the SVG namespace; no handler in an attribute."""
    replay = replay_of(shows_of(recorded))
    assert replay is not None
    html = re.sub(r'(<script type="application/json">).*?(</script>)', r"\1\2", replay.html)
    text = "".join([html, replay.style, replay.script]).replace("http://www.w3.org/2000/svg", "")
    assert not re.search(
        r"https?:|[^:]//[a-z]|url\(|@import|fetch|XMLHttp|\ssrc=|\shref=.(?!#)|\son[a-z]+=|eval\(", text
    )


def test_controls_have_names(recorded):
    """Buttons and fields say what they do, also to who does not see them."""
    replay = replay_of(shows_of(recorded))
    assert replay is not None
    buttons = re.findall(r"<button([^>]*)>([^<]*)<", replay.html)
    assert len(buttons) == 8
    assert all("aria-label" in attributes or text.isascii() for attributes, text in buttons)
    assert len(re.findall(r"<(?:select|input)", replay.html)) == len(re.findall("<label", replay.html)) == 4


def test_there_is_no_replay_of_nothing():
    """A page of an earlier version's cells goes without."""
    assert replay_of([]) is None


def test_the_report_holds_the_replay(recorded, tmp_path):
    """Its section, its data and its script."""
    write_html(Report(recorded), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert 'id="replay-player"' in page
    assert "Plays recorded joint positions" in page


@pytest.mark.parametrize(("count", "most"), [(1, 120_000), (MANY, 1_000_000)])
def test_the_replay_is_small(recorded, count, most):
    """One comparison, and as many as a large matrix has, of full length."""
    (show,) = shows_of(recorded)
    long = tuple(
        replace(
            side,
            episodes=tuple(
                it._replace(
                    steps=np.arange(101),
                    **{name: np.resize(getattr(it, name), (101, *getattr(it, name).shape[1:])) for name in ARRAYS},
                    target=np.resize(it.target[0], (101, 3)),
                )
                for it in (side.episodes * 2)[:6]
            ),
        )
        for side in show.sides
    )
    replay = replay_of([replace(show, numbers=tuple(range(1, 7)), sides=long)] * count)
    assert replay is not None
    assert len("".join(replay[:3])) < most


ARRAYS = ("qpos", "distance", "paid")
