"""Charts and histories as Weights & Biases exports them."""

from tests.plugins.logs.reading import Reader

TAG = "charts/episodic_return"

read = Reader("table")


def chart(folder, names, rows, axis="global_step"):
    """A chart in the form of the service's page: every cell in quotes, each curve with its least and greatest."""
    path = folder / "wandb_export_2026-01-01T00_00_00.csv"
    header = [axis, *(f"{name}{end}" for name in names for end in ("", "__MIN", "__MAX"))]
    lines = [header, *([row[0], *(cell for cell in row[1:] for _ in range(3))] for row in rows)]
    path.write_text("\n".join(",".join(f'"{cell}"' for cell in line) for line in lines), encoding="utf-8")
    return path


def test_a_chart_says_that_it_is_thinned(tmp_path):
    """The service samples points before it exports them."""
    log = read(chart(tmp_path, [f"base - {TAG}"], [[0, -1.5], [100, -0.5]]))
    assert log.facts.thinned == "Weights & Biases samples a curve before it exports it"
    assert log.facts.unit == "point"


def test_a_curve_of_means_says_so(tmp_path):
    """Of points that were joined, or of a group of runs."""
    path = tmp_path / "group.csv"
    path.write_text(f'"global_step","ppo - {TAG}","ppo - {TAG}__MIN","ppo - {TAG}__MAX"\n"0","2","1","3"\n')
    log = read(path)
    assert log["reward/recorded"].tolist() == [2.0]
    assert "or of the runs of a group" in log.facts.thinned


def test_a_run_of_cleanrl_tells_environment_algorithm_and_seed(tmp_path):
    """By its name."""
    log = read(chart(tmp_path, [f"Hopper-v4__ppo__5__1700000000 - {TAG}"], [[0, -1.5]]))
    assert (log.facts.env, log.facts.algorithm, log.facts.seed) == ("Hopper-v4", "ppo", 5)


def test_names_with_the_separator_are_split_at_its_last_place(tmp_path):
    """A run may be called anything; the columns of `_step` that some exports have are no curves."""
    log = read(chart(tmp_path, ["my - base - _step", f"my - base - {TAG}"], [[0, 1, -1.5]]))
    assert log.facts.run == "my - base"
    assert log["reward/recorded"].tolist() == [-1.5]


def test_the_history_of_a_run_is_read_as_its_interface_gives_it(tmp_path):
    """Columns by name, an index in front, `global_step` as what it logged counts steps."""
    path = tmp_path / "history.csv"
    path.write_text(
        f",_step,_runtime,_timestamp,global_step,{TAG},losses/v\n"
        "0,0,1.5,1700000000,128,-2.5,\n1,1,2.5,1700000001,128,,0.5\n2,2,3.5,1700000002,256,-1.25,\n"
    )
    log = read(path)
    assert log["time"].tolist() == [128, 256]
    assert log["reward/recorded"].tolist() == [-2.5, -1.25]
    assert "samples" in log.facts.thinned


def test_tables_of_others_are_not_recognised(tmp_path):
    """Nor a name with a dash."""
    for name, text in [("a.csv", "Step,loss - total\n1,2\n"[5:]), ("b.csv", "reward\n1\n"), ("c.csv", "x,a-b\n1,2\n")]:
        path = tmp_path / name
        path.write_text(text)
        assert not read.is_recognised(path)
