"""What the audit says of the stories in ``examples/stories``, and what ``docs/studies/stories.md`` tells of it."""

import re

import pytest

from harness import load_registry
from harness.experiment.screening import FAILING, NOTHING
from harness.registry import choose, read_given
from harness_plugins.audit import find_cheats
from tests.project import ROOT, page_of

PAGE = page_of("studies/stories")
STORIES = sorted((ROOT / "examples" / "stories").glob("*.py"))
PAIR = re.compile(r"earns (\S+), .*? (\S+) \(")
"""What failing and doing the task earn, in the first sentence of an answer."""


def found_in(path, **how):
    """What a search finds, by reward."""
    registry = load_registry(given=read_given([str(path)]))
    story = choose(registry, "environments", path.stem).build(registry, "environments")
    rewards = story.rewards(None)
    audit = find_cheats(story.make, rewards, behaviour=story.behaviour(None), success="success", **how)
    return dict(zip(rewards, audit.cheats, strict=True))


def test_a_story_and_its_twin_are_told_apart():
    """By a budget that counts out a small world."""
    found = found_in(ROOT / "examples" / "stories" / "boat_race.py", budget=20_000, starts=1)
    assert {name: it.word for name, it in found.items()} == {"hacked": FAILING, "honest": NOTHING}


def test_the_page_has_all_stories():
    """Each with its file, and a command that names it."""
    linked = re.findall(r"^\| \[[^]]+\]\(\.\./\.\./examples/stories/(\w+\.py)\)", PAGE, re.MULTILINE)
    assert sorted(linked) == [it.name for it in STORIES]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("path", STORIES, ids=lambda it: it.stem)
def test_every_seed_finds_the_cheat_and_none_in_the_twin(path, seed):
    """The page tells the numbers of the first seed; those of a table are the same everywhere."""
    found = found_in(path, seed=seed)
    assert {name: it.word for name, it in found.items()} == {"hacked": FAILING, "honest": NOTHING}
    (row,) = (line for line in PAGE.splitlines() if f"stories/{path.name})" in line)
    for it in found.values():
        if seed == 0 and it.searched.how == ("table",):
            assert "/".join(PAIR.search(it.lines[0]).groups()) in row
