"""The files of a summary, and how they take the place of older ones."""

import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import replace

import pytest

from harness.report import Report
from harness.report.document import report_text
from harness.text import LONGEST_STEM
from harness_plugins.committed.records import PARTIAL, figure_stems, put_files, write_summary
from harness_plugins.committed.svg import CREATOR
from tests.plugins.committed.kept import RECORDS
from tests.refusals import refused

STEM = "mujoco-sac-fd100-fd100-reach-arp-against-baseline"


def names(folder):
    """Every file in it, by its path within it."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_folder_has_every_record(summarise):
    """Records, one page, and the figures; nothing else."""
    assert names(summarise(learned={10: 1})) == {
        *RECORDS,
        "figures/overview.svg",
        *(f"figures/{STEM}.{what}.svg" for what in ("runs", "split", "learning")),
    }


def test_learning_without_evaluations_is_that_of_the_training(summarise):
    """Where policies were evaluated at the end alone."""
    assert f"figures/{STEM}.learning.svg" in names(summarise())


def test_experiment_is_the_folder_s(build, tmp_path):
    """Byte for byte."""
    results = build()
    write_summary(results, tmp_path / "mine")
    assert (tmp_path / "mine" / "experiment.toml").read_bytes() == (results.folder / "experiment.toml").read_bytes()


def test_plugin_files_are_named_from_where_it_is_written(build, tmp_path, monkeypatch):
    """Those that lie below: whoever gets the summary has other folders above."""
    results = build()
    text = '[[plugins]]\npath = "{}/mine/reward.py"\n\n[[plugins]]\npath = "/elsewhere/reward.py"\n'
    monkeypatch.setattr(type(results), "experiment_text", text.format(tmp_path.as_posix()))
    monkeypatch.chdir(tmp_path)
    write_summary(results, tmp_path / "told")
    assert tomllib.loads((tmp_path / "told" / "experiment.toml").read_text()) == {
        "plugins": [{"path": "mine/reward.py"}, {"path": "/elsewhere/reward.py"}]
    }


def test_results_are_what_json_prints(build, tmp_path):
    """One document, not two."""
    results = build()
    write_summary(results, tmp_path / "mine")
    text = (tmp_path / "mine" / "results.json").read_text()
    assert text == report_text(Report(results)) + "\n"
    assert json.loads(text)["combinations"][0]["proposed"] == "arp"


def test_same_results_give_the_same_bytes(build, tmp_path):
    """Every file, figures included."""
    results = build(learned={10: 1})
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        write_summary(results, folder)
    one, two = ({name: (folder / name).read_bytes() for name in names(folder)} for folder in folders)
    assert one == two


def test_no_finished_combination_is_a_summary_too(summarise):
    """It has every record, and no figure."""
    assert names(summarise(ended={("arp", seed): ("failed", "it broke") for seed in range(3)})) == RECORDS


def test_null_control_has_figures(summarise):
    """The baseline against itself is a combination like any other."""
    assert "figures/mujoco-sac-fd100-fd100-reach-baseline-against-baseline.split.svg" in names(summarise(a_a=True))


def test_folder_of_an_experiment_is_refused(build):
    """Another experiment's own record would be overwritten."""
    results, other = build(), build()
    before = names(other.folder)
    with refused("is the folder of an experiment: name another"):
        write_summary(results, other.folder)
    assert names(other.folder) == before


def test_nothing_heavy_is_imported(build, tmp_path):
    """Neither an engine nor a learning library, nor one that draws."""
    results = build(learned={10: 1})
    code = (
        "import sys, harness_plugins.committed.records as summary\n"
        "from harness import load_results\n"
        "from pathlib import Path\n"
        "summary.write_summary(load_results(sys.argv[1]), Path(sys.argv[2]))\n"
        "heavy = {'torch', 'mujoco', 'pybullet', 'dm_control', 'stable_baselines3', 'gymnasium', 'matplotlib'}\n"
        "print(*(heavy & set(sys.modules)))\n"
    )
    command = [sys.executable, "-c", code, str(results.folder), str(tmp_path / "mine")]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.returncode) == ("\n", 0), ended.stderr


def test_names_are_safe_and_say_what_it_is(build):
    """Lower-case letters, digits, dots and hyphens."""
    (stem,) = figure_stems(build(proposed={"arp:k1=2,k2=3.25": (9, 30)}).combinations)
    assert stem == "mujoco-sac-fd100-fd100-reach-arp-k1-2-k2-3.25-against-baseline"


def test_no_two_are_alike(build):
    """Labels that differ in signs alone still give two names."""
    (combination,) = build().combinations
    stems = figure_stems([replace(combination, proposed=label) for label in ("x:k=1", "x:k=-1", "X:k=1")])
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


OLD = {"a.txt": b"old a", "b.txt": b"old b", "figures/c.svg": b"old c"}
NEW = {"a.txt": b"new a", "b.txt": b"new b", "figures/c.svg": b"new c"}


def read(folder):
    """Everything in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def folder(tmp_path):
    """One that holds an older summary, and a file of somebody else's."""
    put_files(tmp_path / "mine", OLD, "figures")
    (tmp_path / "mine" / "published.toml").write_bytes(b"theirs")
    return tmp_path / "mine"


def test_old_files_are_replaced_and_others_stay(folder):
    """Ours are the new ones; nothing else is touched or left over."""
    put_files(folder, NEW, "figures")
    assert read(folder) == {**NEW, "published.toml": b"theirs"}


def test_error_while_writing_leaves_the_old_files(folder, monkeypatch):
    """A full disk costs nothing: one line, the old files, no remains."""
    written = []

    def refuse(path, content):
        if written:
            raise OSError(28, "No space left on device")
        written.append(path)

    monkeypatch.setattr("pathlib.Path.write_bytes", refuse)
    with refused("mine' cannot be written: No space left on device"):
        put_files(folder, NEW, "figures")
    assert read(folder) == {**OLD, "published.toml": b"theirs"}


def test_killed_writer_leaves_whole_old_files(folder):
    """Killed before the last file is written, the folder is as it was; the next writer clears what is left."""
    code = (
        "import os, pathlib, signal, sys\n"
        "from harness_plugins.committed.records import put_files\n"
        "write = pathlib.Path.write_bytes\n"
        "def write_half(path, content):\n"
        "    write(path, content[:2])\n"
        "    if path.name == 'c.svg': os.kill(os.getpid(), signal.SIGKILL)\n"
        "pathlib.Path.write_bytes = write_half\n"
        f"put_files(pathlib.Path(sys.argv[1]), {NEW!r}, 'figures')\n"
    )
    assert subprocess.run([sys.executable, "-c", code, str(folder)], check=False).returncode == -9
    left = {name: content for name, content in read(folder).items() if not name.startswith(PARTIAL)}
    assert left == {**OLD, "published.toml": b"theirs"}
    assert (folder / PARTIAL).is_dir()
    put_files(folder, NEW, "figures")
    assert read(folder) == {**NEW, "published.toml": b"theirs"}


def test_interrupted_renaming_leaves_whole_files(folder, monkeypatch):
    """Each file is the old one or the new one."""
    replace, renamed = os.replace, []

    def replace_once(source, target):
        if renamed:
            raise KeyboardInterrupt
        renamed.append(target)
        replace(source, target)

    monkeypatch.setattr("os.replace", replace_once)
    with pytest.raises(KeyboardInterrupt):
        put_files(folder, NEW, "figures")
    left = read(folder)
    assert set(left) == {*OLD, "published.toml"}
    assert all(left[name] in (OLD[name], NEW[name]) for name in OLD)


def test_our_older_figures_go(folder):
    """One that is not drawn any more would be taken for a result."""
    for name in ("overview", "a.runs", "a-b.1.split", "a.learning"):
        (folder / "figures" / f"{name}.svg").write_text(f"<svg>{CREATOR}</svg>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg"}


@pytest.mark.parametrize("name", ["theirs.svg", "a.runs-kept.svg", "runs.svg", "overview2.svg", "a.runs.kept.svg"])
def test_figures_of_another_name_stay(folder, name):
    """A copy of ours that somebody renamed is theirs."""
    (folder / "figures" / name).write_text(f"<svg>{CREATOR}</svg>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg", name}


def test_figures_of_another_creator_stay(folder):
    """Whatever their name."""
    (folder / "figures" / "overview.svg").write_text("<svg/>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg", "overview.svg"}


def test_folder_that_is_a_file_is_refused(tmp_path):
    """In one line."""
    (tmp_path / "mine").touch()
    with refused("mine' cannot be written"):
        put_files(tmp_path / "mine", NEW, "figures")
