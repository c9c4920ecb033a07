"""Trainings that are equal bit for bit."""

from harness.eta import equal_sentences, equal_trainings
from harness.eta.equal import key_to_json


def test_equal_digests_stand_together():
    """Each training in one group at most; one that is like no other in none."""
    digests = {("a", 0): "x", ("b", 0): "x", ("a", 1): "y", ("c", 4): "x", ("d", 0): "z", ("d", 1): "y"}
    assert equal_trainings(digests) == ((("a", 0), ("b", 0), ("c", 4)), (("a", 1), ("d", 1)))


def test_a_training_without_a_digest_is_like_no_other():
    """Nothing in it tells it apart."""
    assert equal_trainings({("a", 0): "", ("b", 0): ""}) == ()


def test_rewards_that_taught_the_same_have_one_sentence_for_all_seeds():
    """With the consequence."""
    groups = [(("own", seed), ("copy", seed)) for seed in (0, 1, 4)]
    assert equal_sentences(groups) == [
        "The trainings by own and copy are equal bit for bit, with seeds 0, 1 and 4: between them there is nothing to "
        "compare"
    ]
    assert equal_sentences([(("a", 3), ("b", 3), ("c", 3))]) == [
        "The trainings by a, b and c are equal bit for bit, with seed 3: between them there is nothing to compare"
    ]


def test_seeds_that_gave_one_run_are_told():
    """They are counted as several, which they are not."""
    assert equal_sentences([(("own", 0), ("own", 3))]) == [
        "The trainings by own with seed 0 and by own with seed 3 are equal bit for bit. They count as several, but are "
        "one"
    ]


def test_a_key_is_plain_data():
    """By names."""
    assert key_to_json(("own", 3)) == {"trained_by": "own", "seed": 3}
