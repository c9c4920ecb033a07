import re
import shlex
import subprocess
import sys

import pytest

HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward\n"
BASE = ",1,1,1,0,0\n,1,1,2,,-1\n,1,1,0.5,,0.5\n,1,0.5,0.5,,0.5\n,1,0.5,0.25,,0.75\n"
K2 = "0,1,1,1,0,0\n1,1,1,1.5,0.5,-0.5\n"
K2 += "2,1,0.5,0.5,-0.5,0.75\n3,1,0.25,0.25,-0.25,1.125\n4,1,0.125,0.125,-0.125,1.3125\n"


@pytest.fixture
def recorded(harness, tmp_path):
    """Flags that name two groups of two files each, one of either program."""
    for name, rows in (("base", BASE), ("k2", K2)):
        (tmp_path / name).mkdir()
        for number in range(2):
            (tmp_path / name / f"{number}.csv").write_text(HEADER + rows)
    return ("--baseline", "base/*.csv", "--proposed", "k2/*.csv")


def test_json_is_all_that_goes_to_standard_output(harness, recorded):
    """`--json` prints one document with the indices, the etas and their parts."""
    answer = harness("eta", *recorded, "--json")
    data = answer.json
    assert (answer.status, answer.err) == (0, "")
    assert data["baseline"] == {"first_negative": 1, "crossover": 3, "steps": 5, "I_N": -1.5, "I_P": 0.8, "total": -0.8}
    assert data["proposed"] == {"first_negative": 1, "crossover": 2, "steps": 5, "I_N": -0.5, "I_P": 4.3, "total": 3.8}
    assert data["eta_N"]["eta"]["value"] == pytest.approx(0.5 / 1.5)
    assert data["eta_P"]["eta"]["value"] == pytest.approx((0.25 + 1.375 + 2.6875) / 0.75)
    on_proposed, on_baseline = data["eta_N"]["paths"]
    assert on_proposed["behaviour"]["value"] == pytest.approx(0.5 / 1.5)
    assert on_proposed["ruler"]["value"] == pytest.approx(1.0)
    assert on_baseline["ruler"]["value"] == pytest.approx(1.25 / 1.5)
    assert data["eta_N"]["ruler"]["value"] == pytest.approx((1.25 / 1.5) ** 0.5)
    assert data["rewards"] == {"baseline": "baseline", "proposed": "arp:k1=1,k2=1.5"}
    assert {"value", "low", "high", "seeds", "note"} == set(data["eta_P"]["ruler"])


def test_the_table_is_the_default(harness, recorded):
    """The number in words, ratios, parts and indices go to standard output."""
    answer = harness("eta", *recorded)
    assert (answer.status, answer.err) == (0, "")
    for told in ("arp:k1=1,k2=1.5", "baseline 2 runs", "eta_N", "eta_P", "interaction", "accumulated reward", "I_N"):
        assert told in answer.out


def test_the_per_step_curve_is_told_as_such(harness, recorded):
    """I_N up to and with the cross-over, I_P behind it; the table's heading says which curve it is."""
    data = harness("eta", *recorded, "--curve", "per-step", "--json").json
    assert data["curve"] == "per-step"
    assert data["baseline"] == {"first_negative": 1, "crossover": 2, "steps": 5, "I_N": -0.5, "I_P": 1.2, "total": 0.8}
    assert "per-step reward" in harness("eta", *recorded, "--curve", "per-step").out


def test_a_flag_may_be_repeated(harness, recorded, tmp_path):
    """Several patterns make one group; a file that two of them match is one run."""
    (tmp_path / "more.csv").write_text(HEADER + BASE)
    answer = harness("eta", *recorded, "--baseline", "base/0*", "--baseline", "more.csv", "--json")
    assert answer.json["runs"] == {"baseline": 3, "proposed": 2}


def test_rows_behind_the_shortest_run_are_told(harness, recorded, tmp_path):
    """A reader sees that not all of every file was compared."""
    for path in sorted((tmp_path / "base").iterdir()):
        with path.open("a") as file:
            file.write(",1,0.25,0.25,,0.75\n")
    out = harness("eta", *recorded).out
    assert "baseline 2 runs (2 rows " in out
    assert "proposed 2 runs\n" in out
    assert "of the shortest, 'k2/0.csv'; the longest has 6\n" in out


def test_a_training_that_diverged_is_left_out_by_name_alone(harness, recorded, tmp_path):
    """What the message says to type leads to the answer of those that are whole."""
    text = (tmp_path / "base" / "1.csv").read_text()
    (tmp_path / "base" / "2.csv").write_text(text.replace(",,0.75", ",,nan"))
    said = harness("eta", *recorded, "--json")
    assert (said.status, said.out) == (2, "")
    assert "'base/2.csv' is missing: it is paid no number from step 4 on" in said.err
    answer = harness("eta", *recorded, *shlex.split(re.findall("--leave-out '.*?'", said.err)[0]), "--json")
    assert answer.json["runs"] == {"baseline": 2, "proposed": 2}
    assert "base/2.csv' is left out, as --leave-out says" in answer.err


def test_unequal_budgets_are_no_difference(harness, tmp_path):
    """Twice as many steps of the same rewards: both are cut to the common ones, eta_N is 1, and it is told."""
    for name, pairs in (("short", 500), ("long", 1000)):
        (tmp_path / name).mkdir()
        for number in range(3):
            (tmp_path / name / f"{number}.csv").write_text("reward\n" + "0.5\n-1\n" * pairs)
    data = harness("eta --baseline 'short/*.csv' --proposed 'long/*.csv' --json").json
    assert data["eta_N"]["eta"]["value"] == 1.0
    assert data["baseline"] == data["proposed"]
    assert data["rows_left_out"] == {"baseline": 0, "proposed": 3000}
    assert (
        data["notes"][0] == "All runs are cut to the 1,000 steps of the shortest, 'short/0.csv'; the longest has 2,000"
    )


@pytest.mark.parametrize(
    ("files", "folder", "command"),
    [
        (["it/a0.csv", "it/b0.csv", "it/c0.csv"], "it", "are of 3 rewards, `a` 1, `b` 1, `c` 1; two are compared"),
        (["it/0.csv"], "it/0.csv", "harness eta --baseline it/0.csv --proposed 'OTHER/*.csv' compares their pay"),
    ],
)
def test_what_is_no_folder_of_trainings_is_told_the_command(harness, tmp_path, files, folder, command):
    """CSV files, a single one, a data set: one line, with the names filled in."""
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("reward\n1\n2\n")
    answer = harness("eta", folder)
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert command in answer.err


@pytest.mark.parametrize(
    ("files", "told"),
    [
        (["it/base/0.csv", "it/k2/0.csv"], "CSV files: 1 of `base`, the baseline, and 1 of `k2`"),
        (
            ["it/k2/0.csv", "it/my-base/0.csv", "it/my-base/1.csv"],
            "CSV files: 2 of `my-base`, the baseline, and 1 of `k2`",
        ),
        (["it/arp_seed0.csv", "it/base_1.csv"], "CSV files: 1 of `base`, the baseline, and 1 of `arp`"),
    ],
)
def test_csv_files_of_a_folder_are_sorted_by_their_names(harness, tmp_path, files, told):
    """Two rewards: what is called a baseline is the baseline, and standard error says which files were compared."""
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("reward\n" + ("-3\n3\n" if "base" in name else "-1\n2\n"))
    answer = harness("eta it --json")
    data = answer.json
    assert (answer.status, answer.err) == (0, f"{told}\n")
    assert (data["baseline"]["I_N"], data["proposed"]["I_N"]) == (-3.0, -1.0)


def test_the_baseline_of_a_folder_can_be_named(harness, tmp_path):
    """``--baseline`` takes the name of one of the rewards; another name is answered with those that there are."""
    for name, pay in (("base", "-3\n3\n"), ("k2", "-1\n2\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "0.csv").write_text(f"reward\n{pay}")
    assert harness("eta . --baseline k2 --json").json["baseline"]["I_N"] == -1.0
    assert "There are: base, k2" in harness("eta . --baseline k3").err


def test_plot_writes_a_page(harness, recorded, tmp_path):
    """Where it is told, and says so on standard error; the table goes to standard output as ever."""
    pytest.importorskip("jinja2")
    answer = harness("eta", *recorded, "--plot", "curves.html")
    assert (answer.status, answer.err) == (0, "Figure: curves.html\n")
    assert "eta_N" in answer.out
    assert "<html" in (tmp_path / "curves.html").read_text()


LOADED = 81
"""Modules of this project, of some 500. Others that open files of a plugin, or of a reward, come with these."""


def loaded_by(*arguments):
    """The modules of this project that a command loads, in a process of its own."""
    code = (
        "import sys; from harness.cli import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit: print(*(name for name, it in sys.modules.items() "
        "if name.split('.')[0] == 'harness' and getattr(it, '__file__', None)), file=sys.stderr)"
    )
    told = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return set(told.stderr.split())


def test_few_modules_are_loaded(tmp_path):
    """Neither other commands, nor what reads experiments, for two files of rewards; with distances, what pays them."""
    bare, full = tmp_path / "bare.csv", tmp_path / "full.csv"
    bare.write_text("reward\n-1\n1\n2\n")
    full.write_text(HEADER + K2)
    for path, most in ((bare, LOADED), (full, LOADED + 6)):
        loaded = loaded_by("eta", "--baseline", str(path), "--proposed", str(path))
        assert "harness.score.compare" in loaded
        assert len(loaded) <= most
        rooms = {name.split(".")[1] for name in loaded if "." in name}
        assert not rooms & {"results", "experiment", "env", "robot", "audit", "recorder"}
