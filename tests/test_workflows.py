"""What the workflows may do and what they run: a release is built where nothing can be published."""

import re

import pytest
import yaml

from tests.project import ROOT

WORKFLOWS = sorted(ROOT.glob(".github/workflows/*.yml"))
PINNED = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")
DIGESTS = "sha256sum dist/* build/sbom/*.json"
EACH = pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)


def _read(path):
    """A workflow; YAML calls its key `on` true."""
    return yaml.safe_load(path.read_text())


@pytest.fixture
def release():
    """The jobs of a release."""
    return _read(ROOT / ".github/workflows/release.yml")["jobs"]


def _runs(job):
    return [step["run"] for step in job["steps"] if "run" in step]


def _actions(job):
    return [step["uses"].partition("@")[0] for step in job["steps"] if "uses" in step]


def test_there_are_workflows_to_look_at():
    """Else the tests below would hold nothing."""
    assert [path.stem for path in WORKFLOWS] == ["fuzz", "release", "test"]


@EACH
def test_every_action_is_named_by_its_commit(path):
    """A tag can be moved to other code; behind the commit stands the version, for people and for Dependabot."""
    named = re.findall(r"uses: *(.*)", path.read_text())
    assert named
    assert [name for name in named if not PINNED.fullmatch(name)] == []


def test_an_action_has_one_commit():
    """In all workflows."""
    named = re.findall(r"uses: *(.*)", "".join(path.read_text() for path in WORKFLOWS))
    assert len(set(named)) == len({name.partition("@")[0] for name in named})


def test_actions_are_kept_up_to_date():
    """A commit that stays for ever keeps its faults."""
    updates = yaml.safe_load((ROOT / ".github/dependabot.yml").read_text())["updates"]
    assert "github-actions" in {update["package-ecosystem"] for update in updates}


@EACH
def test_no_checkout_leaves_a_token(path):
    """It would lie in .git/config, for every package that runs later."""
    steps = [step for job in _read(path)["jobs"].values() for step in job["steps"]]
    checkouts = [step for step in steps if step.get("uses", "").startswith("actions/checkout@")]
    assert checkouts
    assert all(step["with"]["persist-credentials"] is False for step in checkouts)


@EACH
def test_a_workflow_may_only_read(path):
    """What a job needs besides stands at the job."""
    assert _read(path)["permissions"] in ({}, {"contents": "read"})


def test_only_one_job_can_publish(release):
    """PyPI takes what comes with this permission."""
    assert [name for name, job in release.items() if "id-token" in job["permissions"]] == ["publish"]
    assert [name for name, job in release.items() if "pypa/gh-action-pypi-publish" in _actions(job)] == ["publish"]


def test_what_builds_may_only_read(release):
    """There the packages of others run."""
    assert release["build"]["permissions"] == {"contents": "read"}


@pytest.mark.parametrize("name", ["publish", "files"])
def test_where_something_is_written_no_code_of_the_repository_runs(release, name):
    """Neither from a checkout nor from a package."""
    assert "actions/checkout" not in _actions(release[name])
    assert not re.search(r"\b(make|pip|python)\b", "\n".join(_runs(release[name])))


@pytest.mark.parametrize("name", ["publish", "files"])
def test_digests_of_the_build_are_compared_before_anything_else(release, name):
    """They come by another way than the files, and name all of them."""
    job = release[name]
    assert "build" in job["needs"]
    assert release["build"]["outputs"] == {"digests": "${{ steps.digests.outputs.sha256 }}"}
    (told,) = (step["run"] for step in release["build"]["steps"] if step.get("id") == "digests")
    fetched, compared = job["steps"][:2]
    assert fetched["uses"].startswith("actions/download-artifact@")
    assert compared["env"] == {"DIGESTS": "${{ needs.build.outputs.digests }}"}
    assert compared["run"] == f'diff <(base64 --decode <<< "$DIGESTS") <({DIGESTS})'
    assert DIGESTS in told


def test_files_are_attested_before_they_are_published(release):
    """Where they were built, and with what; PyPI gets an attestation too."""
    steps = release["publish"]["steps"]
    assert _actions(release["publish"])[1:] == [
        "actions/attest-build-provenance",
        "actions/attest-sbom",
        "pypa/gh-action-pypi-publish",
    ]
    assert {step["with"]["subject-path"] for step in steps if "attest" in step.get("uses", "")} == {"dist/*"}
    assert steps[-1]["with"] == {"attestations": True}
    assert release["publish"]["permissions"]["attestations"] == "write"


def test_a_bill_of_materials_comes_with_the_release(release):
    """Made from the locks, by tools that have a lock too."""
    recipe = (ROOT / "Makefile").read_text()
    assert re.search(r"^make (\w+ )*sbom ", _runs(release["build"])[0])
    assert "build/sbom/fd100-harness-run.cdx.json requirements/run.txt" in recipe
    assert "build/sbom/fd100-harness-dev.cdx.json requirements/dev.txt" in recipe
    assert re.search(r"--no-deps --require-hashes --requirement \$<\n\ttouch", recipe)
    assert re.search(r"^cyclonedx-bom==", (ROOT / "requirements/sbom.txt").read_text(), re.MULTILINE)
    assert "build/sbom/*.json" in _runs(release["files"])[-1]


def test_readers_are_fuzzed_each_week():
    """For ten minutes."""
    workflow = _read(ROOT / ".github/workflows/fuzz.yml")
    (when,) = workflow[True]["schedule"]
    (job,) = workflow["jobs"].values()
    assert re.fullmatch(r"\d+ \d+ \* \* \d", when["cron"])
    assert "pytest tests/fuzz -m slow" in _runs(job)[-1]
    assert job["steps"][-1]["env"]["FUZZ_MINUTES"] == "10"


def test_answers_are_held_against_independent_ones_each_week():
    """For other inputs than the week before."""
    (job,) = _read(ROOT / ".github/workflows/fuzz.yml")["jobs"].values()
    assert "pytest tests/oracles -m slow" in _runs(job)[-2]
    assert job["steps"][-2]["env"]["ORACLE_INPUTS"] == "2000"


def test_the_archive_is_built_from_on_every_change():
    """`make wheel` unpacks it and builds a wheel there: tests/installed/test_source_archive.py."""
    (locked,) = (job for name, job in _read(ROOT / ".github/workflows/test.yml")["jobs"].items() if name == "locked")
    assert " wheel " in _runs(locked)[-1]
