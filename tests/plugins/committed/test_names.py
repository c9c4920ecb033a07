"""File names of a combination's figures."""

import re
from dataclasses import replace

from harness.text import LONGEST_STEM
from harness_plugins.committed.records import figure_stems


def test_names_are_safe_and_say_what_it_is(build):
    """Lower-case letters, digits, dots and hyphens."""
    results = build(proposed={"arp:k1=2,k2=3.25": (9, 30)})
    (stem,) = figure_stems(results.combinations)
    assert stem == "mujoco-sac-fd100-fd100-reach-arp-k1-2-k2-3.25-against-baseline"


def test_no_two_are_alike(build):
    """Labels that differ in signs alone still give two names."""
    (combination,) = build().combinations
    twins = [replace(combination, proposed=label) for label in ("x:k=1", "x:k=-1", "X:k=1")]
    stems = figure_stems(twins)
    assert len({stem.lower() for stem in stems}) == 3


def test_long_names_are_cut_and_stay_apart(build):
    """What was cut off still decides."""
    (combination,) = build().combinations
    stems = figure_stems([replace(combination, proposed="a" * 300 + end) for end in ("x", "y")])
    assert len(set(stems)) == 2
    assert all(len(stem) <= LONGEST_STEM and re.fullmatch(r"[a-z0-9.-]+", stem) for stem in stems)


def test_robot_s_folder_is_no_part(build):
    """A robot given by its path is called by its name."""
    (combination,) = build().combinations
    moved = replace(combination, group=combination.group._replace(robot="/somewhere/else/my_arm"))
    assert figure_stems([moved])[0].startswith("mujoco-sac-my-arm-fd100-reach")
