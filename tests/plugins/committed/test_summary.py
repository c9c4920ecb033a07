"""The folder of a summary."""

import json
import subprocess
import sys
import tomllib

import pytest

from harness.errors import UsageError
from harness.report.document import report_text
from harness_plugins.committed.records import write_summary
from tests.plugins.committed.kept import RECORDS

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
    assert text == report_text(results) + "\n"
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
    left = names(summarise(ended={("arp", seed): ("failed", "it broke") for seed in range(3)}))
    assert left == RECORDS


def test_null_control_has_figures(summarise):
    """The baseline against itself is a combination like any other."""
    left = names(summarise(a_a=True))
    assert "figures/mujoco-sac-fd100-fd100-reach-baseline-against-baseline.split.svg" in left


def test_folder_of_an_experiment_is_refused(build):
    """Another experiment's own record would be overwritten."""
    results, other = build(), build()
    before = names(other.folder)
    with pytest.raises(UsageError, match="is the folder of an experiment: name another"):
        write_summary(results, other.folder)
    assert names(other.folder) == before


def test_nothing_heavy_is_imported(build, tmp_path):
    """Neither an engine nor a learning library, nor one that draws."""
    results = build(learned={10: 1})
    code = (
        "import sys, harness_plugins.committed.records as summary\n"
        "from harness.results import load_results\n"
        "from pathlib import Path\n"
        "summary.write_summary(load_results(sys.argv[1]), Path(sys.argv[2]))\n"
        "heavy = {'torch', 'mujoco', 'pybullet', 'dm_control', 'stable_baselines3', 'gymnasium', 'matplotlib'}\n"
        "print(*(heavy & set(sys.modules)))\n"
    )
    command = [sys.executable, "-c", code, str(results.folder), str(tmp_path / "mine")]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.returncode) == ("\n", 0), ended.stderr
