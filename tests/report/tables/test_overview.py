from harness.report import FactsTable, Report
from harness.results.overview import pay_texts
from tests.report import conftest
from tests.report.conftest import MIXTURE, squeezed
from tests.report.tables.test_comparison import CASES

REWARDS = {"arp": (9, 30), "relative": (9, 20), "scaled:factor=1.5": (9, 30)}


def printed(results, *console, **given):
    """What goes to a terminal."""
    return conftest.printed(FactsTable(Report(results).short), *console, **given)


def test_nothing_is_cut(build, subtests):
    """One line holds the answer and both etas, whatever they are."""
    for width in [60, 80, 120]:
        for case in CASES:
            with subtests.test(width=width, case=case):
                text = printed(build(**CASES[case]), width)
                assert "…" not in text
                assert max(map(len, text.splitlines())) <= width


def test_a_matrix_is_one_line_per_comparison(build):
    """What is the same everywhere is said once, and the groups are headed by what differs."""
    text = printed(build(proposed=REWARDS, simulators=("mujoco", "pybullet")))
    assert text.splitlines()[0] == "sac · fd100 · fd100-reach · against baseline · 40 steps · 3 seeds"
    assert [text.count(f"\n{label} ") for label in REWARDS] == [2, 2, 2]
    assert [text.count(f"\n{name}\n") for name in ("mujoco", "pybullet")] == [1, 1]
    assert text.index("Over all places") < text.index("\nmujoco\n")
    assert len(text[text.index("\nmujoco\n") : text.index("The note's eta_N")].splitlines()) < 25


def test_one_reward_on_several_simulators_is_named_by_them(build):
    """The reward is what is the same."""
    text = printed(build(simulators=("mujoco", "pybullet")))
    assert text.startswith("sac · fd100 · fd100-reach · arp · against baseline")
    assert "\nmujoco  " in text
    assert "\npybullet  " in text


def test_intervals_stand_where_there_is_room(build):
    """At 120 columns; at 60 the lines would be broken."""
    results = build()
    (told, _, _) = pay_texts(results.combinations[0].number.pay, with_intervals=True)[1:]
    assert " [" in told
    assert told in printed(results, 120)
    (line,) = (line for line in printed(results, 60).splitlines() if "CANNOT TELL" in line)
    assert "[" not in line


def test_a_single_comparison_is_told_in_sentences(build):
    """Those of the report; of many they stand behind `--details`."""
    (combination,) = (results := build()).combinations
    text = squeezed(printed(results))
    assert squeezed(combination.headline.robot) in text
    assert squeezed(combination.pay_sentence) in text
    assert "fewest trainings: harness run" in text
    assert "fewest trainings" not in printed(build(proposed=REWARDS))


def test_answer_has_a_colour_beside_its_word(build):
    """On a terminal alone, and there not against NO_COLOR."""
    helped = build(seeds=6, reached={"arp": lambda seed: (8, 9, 10, 8), "baseline": lambda seed: ()})
    assert "\x1b[1;32m" in printed(helped, force_terminal=True, color_system="standard")
    assert "\x1b[1;32m" not in printed(helped, force_terminal=True, color_system="standard", no_color=True)
    assert "HELPS" in printed(helped)


def test_cells_that_are_not_done_are_told(build):
    """How many, and why."""
    text = printed(build(ended={("arp", 0): ("failed", "the arm fell off"), ("arp", 1): ("pending", "")}))
    assert "6 cells: 4 done, 1 failed, 1 pending" in text
    assert "the arm fell off" in text


def test_mixture_is_marked(mixed):
    """A warning does not wait for the details."""
    assert MIXTURE in squeezed(printed(mixed))
