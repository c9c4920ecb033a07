"""Other weights of the terms in recordings of environments."""

import numpy as np
import pytest

from harness.record import read_recording
from harness.score.weighted_recordings import pay_by_weights, recorded_weights, recordings_of
from tests.record.recording.told import terms_of
from tests.refusals import refused
from tests.results.recordings.test_terms import _record


@pytest.fixture
def runs(tmp_path):
    """Two recordings of a reward with terms."""
    return [_record(tmp_path / str(seed), "calm", seed, np.linspace(0.0, 1.0 + seed, 8)) for seed in range(2)]


def test_a_recording_is_paid_from_its_columns(runs):
    """A column of the new reward, and one of each of its terms; the steps stay as they are."""
    before = {path.name: path.read_bytes() for path in runs[0].iterdir()}
    assert pay_by_weights(runs[0], recorded_weights("calm:calm=3", runs)) == 40
    found = read_recording(runs[0])
    then, now = terms_of(found, "calm"), terms_of(found, "calm:calm=3")
    np.testing.assert_allclose(now["calm"], 3.0 * then["calm"], rtol=1e-15)
    np.testing.assert_allclose(found["reward/calm:calm=3"], then["near"] + 3.0 * then["calm"], rtol=1e-12)
    assert {name: (runs[0] / name).read_bytes() for name in before} == before


def test_weights_follow_weights(runs):
    """Relative to the function's own terms, whatever was recorded first."""
    pay_by_weights(runs[0], "calm:calm=0")
    pay_by_weights(runs[0], "calm:calm=4")
    found = read_recording(runs[0])
    np.testing.assert_allclose(found["reward/calm:calm=4/calm"], 4.0 * found["reward/calm/calm"], rtol=1e-15)


def test_what_is_not_recorded_is_told(runs):
    """The reward nowhere, the term in the reward."""
    assert recorded_weights("other:calm=3", runs) == ""
    with refused(r"Reward 'calm' has no term 'clam' to weigh.*Did you mean 'calm'"):
        recorded_weights("calm:clam=3", runs)
    with refused("no columns of the terms of 'other': give its file"):
        pay_by_weights(runs[0], "other:calm=3")


def test_recordings_lie_at_any_depth(runs, tmp_path):
    """In a folder that is no experiment's."""
    assert [*recordings_of(tmp_path)] == runs
