"""``--fail-on``: the exit status by what was answered."""

import shlex

import pytest

from harness.cli.fail_on import NAMES, Said, decide, named_answers, status_of
from harness.eta import RANKS, Answer
from harness.experiment.screening import CANNOT_TELL, FAILING, LOITERING, NOTHING
from tests.cli.conftest import QUICK
from tests.cli.test_logs import write_monitor
from tests.refusals import refused


def said(*words, question="pay"):
    """An answer for each word, of rewards that are called by number."""
    return [Said(question, f"reward {number}", word) for number, word in enumerate(words)]


@pytest.mark.parametrize(
    ("named", "words", "status"),
    [
        (["failing"], [FAILING], 1),
        (["failing"], [NOTHING, CANNOT_TELL, FAILING], 1),
        (["failing"], [NOTHING], 0),
        (["failing"], [LOITERING], 0),
        (["failing", "loitering"], [LOITERING], 1),
        (["failing"], [CANNOT_TELL], 3),
        (["failing"], [NOTHING, CANNOT_TELL], 3),
        (["failing"], [LOITERING, CANNOT_TELL], 3),
        (["failing", "cannot-tell"], [NOTHING, CANNOT_TELL], 1),
        (["cannot-tell"], [NOTHING], 0),
        (["cannot-tell"], [], 3),
        (["failing"], [], 3),
    ],
)
def test_status_follows_from_what_was_said(named, words, status):
    """A named answer comes before one that is not known, and that before none."""
    assert decide(named, said(*words))[0] == status


def test_question_that_nobody_asked_cannot_be_told():
    """That a robot does better says nothing of what its reward pays for."""
    status, told = decide(["failing"], said("HELPS", question="behaviour"))
    assert (status, told) == (3, "nobody asked what a reward pays for")


def test_other_question_that_cannot_tell_counts_for_nothing():
    """Who fails on what hurts need not know what the reward pays for."""
    assert decide(["hurts"], [*said("HELPS", question="behaviour"), *said(CANNOT_TELL)])[0] == 0


def test_ahead_so_far_counts_as_not_known():
    """Only these trainings differ: who fails on what hurts does not know it yet; its word is told as it was shown."""
    so_far = said("BEHIND SO FAR", question="behaviour")
    assert [decide([name], so_far)[0] for name in ("hurts", "cannot-tell")] == [3, 1]
    assert "BEHIND SO FAR" in decide(["hurts"], so_far)[1]


def test_every_answer_has_a_name_and_its_own():
    """Those of comparisons but the four that say nothing plain; a name stands for one answer."""
    assert len(NAMES["behaviour"]) == len(Answer) - 4
    every = [name for names in NAMES.values() for name in names]
    assert len(every) == len(set(every))
    assert all(Said(question, "", word).name == name for question, of in NAMES.items() for name, word in of.items())


def test_good_answer_of_a_ranking_has_no_name():
    """Nobody fails on it."""
    assert Said("ranking", "", RANKS).name == ""


def test_names_are_read_as_they_are_shown():
    """In capitals and with a blank too."""
    assert named_answers(["HURTS,no difference", "mixed"], "behaviour") == ("hurts", "no-difference", "mixed")
    assert named_answers(None, "pay") == ()


@pytest.mark.parametrize("named", ["hurt", "", "hurts,", "failing"])
def test_unknown_answer_is_refused(named):
    """With all that there are."""
    with refused("There is: cannot-tell, helps, hurts, "):
        named_answers([named], "behaviour")


def test_what_failed_keeps_its_status(capsys):
    """Nothing that was said takes it away, and one line tells both."""
    assert status_of(["failing"], said(NOTHING), 1) == 1
    assert capsys.readouterr().err == "--fail-on failing: reward 0: NOTHING FOUND, and something failed: status 1\n"


def test_without_the_flag_nothing_changes(capsys):
    """Nor is anything printed."""
    assert [status_of((), said(FAILING), failed) for failed in (0, 1)] == [0, 1]
    assert capsys.readouterr() == ("", "")


def test_long_answer_is_cut(capsys):
    """Three are told, and how many more there are."""
    status_of(["failing"], said(*[FAILING] * 5))
    assert capsys.readouterr().err.endswith("reward 2: PAYS FOR FAILING; and 2 more: status 1\n")


@pytest.mark.parametrize(("shares", "status"), [((8, 2), 1), ((2, 8), 0), ((5, 5), 3)])
def test_report_of_logs_ends_by_its_answer(harness, tmp_path, shares, status):
    """That one hurts, that it helps, and that nothing can be told; standard output is as ever."""
    for reward, share in zip(("base", "prop"), shares, strict=True):
        for seed in range(5):
            success = [(number * 7 + seed) % 10 < share + (seed % 2 - 0.5) for number in range(100)]
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", [0.0] * 100, [20] * 100, success)
    plain, answer = (harness("report . --json", *flags) for flags in ((), ("--fail-on", "hurts")))
    assert (plain.status, answer.status) == (0, status)
    assert plain.out == answer.out
    assert answer.err.startswith("--fail-on hurts: prop against base in ")
    assert answer.err.endswith(f": status {status}\n")


RUN = shlex.join(("run", *QUICK, "--reward", "arp", "--out", "here"))
AUDIT = "audit --episodes 2 --starts 1 --fail-on failing --reward"
ENDED = {
    f"{RUN} --seeds 2 --fail-on no-difference": (
        *(1, "no-difference: arp against baseline in ideal · wander · fd100 · fd100-reach: NO DIFFERENCE"),
    ),
    f"{RUN} --seeds 2 --fail-on hurts": (0, "NO DIFFERENCE"),
    f"{RUN} --seeds 3 --limit 5 --fail-on hurts": (3, "1 pending cells: CANNOT TELL"),
    f"{RUN} --dry-run --fail-on hurts": (3, "no two rewards were compared"),
    f"{RUN} --seeds 1 --baseline none --fail-on hurts": (3, "no two rewards were compared"),
    f"{RUN} --seeds 1 --screen --fail-on failing,hurts": (1, "PAYS FOR FAILING"),
    f"{AUDIT} arp --budget 0": (1, "failing: arp: PAYS FOR FAILING"),
    f"{AUDIT} dense --budget 0": (0, "failing: dense: NOTHING FOUND"),
    f"{AUDIT} arp --budget 2000": (3, "failing: arp in fd100-reach, fd100: CANNOT TELL"),
}
"""Status, and what the last line says, which ends with it."""


@pytest.mark.parametrize("line", ENDED)
def test_command_ends_by_its_answer(harness, line):
    """Trainings go on after an alarm; scripts do not answer in place of a search that was too short."""
    answer, (status, told) = harness(line), ENDED[line]
    last = answer.err.splitlines()[-1]
    assert (answer.status, told in last, last.endswith(f": status {status}")) == (status, True, True), last


def test_run_whose_cells_failed_ends_with_1(harness, quick, tmp_path):
    """As without the flag; its report, which fails in nothing, cannot tell."""
    (tmp_path / "odd.py").write_text(
        "def odd(step):\n    if len(step.distance) != 2:\n        raise ValueError\n    return -step.distance\n"
    )
    flags = ("--plugin", "odd.py", "--reward", "odd", "--out", "here", "--fail-on", "hurts")
    answer = harness("run", *quick, "--seeds", "2", *flags)
    assert answer.status == 1
    assert "and something failed: status 1" in answer.err
    assert harness("report here --plugin odd.py --fail-on hurts").status == 3


def test_screen_decides_before_anything_is_trained(harness, quick, tmp_path):
    """Creeping pays more than finishing under `arp`."""
    answer = harness("run --reward arp --screen --fail-on failing --out here --dry-run", *quick)
    assert answer.status == 1
    (told,) = (line for line in answer.err.splitlines() if line.startswith("  arp: PAYS FOR FAILING. "))
    assert ". Not finishing pays more than finishing: creep earns " in told
    assert "arp in fd100 · fd100-reach: PAYS FOR FAILING" in answer.err.splitlines()[-1]
    assert not (tmp_path / "here").exists()


def test_audit_of_recordings_was_not_asked_what_a_reward_pays_for(harness, finished):
    """Its answers are about episodes."""
    answer = harness("audit", finished(seeds=2), "--fail-on", "failing")
    assert (answer.status, "nobody asked what a reward pays for" in answer.err) == (3, True)


def test_several_folders_have_one_status(harness, quick):
    """As if one run had made them."""
    for name, seeds in (("one", "0,1"), ("two", "2,")):
        harness("run", *quick, "--reward", "arp", "--seeds", seeds, "--out", name)
    assert harness("report one two --fail-on no-difference").status == 1


def test_records_are_refused(harness, quick):
    """They hold no cells."""
    harness("run --reward arp --seeds 1 --out here", *quick)
    harness("report here --summary records")
    answer = harness("report records --fail-on hurts")
    assert answer.status == 2
    assert "--fail-on needs cells" in answer.err
