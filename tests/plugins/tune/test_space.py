"""What a search may choose from."""

import pytest
from hypothesis import given, strategies as st

from harness.errors import UsageError
from harness.registry.registry import Registry
from harness_plugins.tune.space import Options, Range, parse_space

SAC = "algorithm 'sac'"


@pytest.fixture
def sac(toys: Registry):
    """The settings of an algorithm; without its library."""
    from harness_plugins.algorithms.sac import Sac

    return Sac


def test_texts_become_dimensions_of_the_type_of_their_field(sac):
    """Floats, whole numbers, options, and options that are tuples."""
    search = {
        "learning_rate": "1e-4..1e-2:log",
        "batch_size": "64|128",
        "net_arch": "64x64|256x256",
        "train_freq": "1..8",
    }
    assert parse_space(search, sac, SAC) == (
        Range("learning_rate", 1e-4, 1e-2, False, True),
        Options("batch_size", ("64", "128"), (64, 128)),
        Options("net_arch", ("64x64", "256x256"), ((64, 64), (256, 256))),
        Range("train_freq", 1, 8, True, False),
    )


def test_lists_of_a_file_are_options(sac):
    """A TOML list means what its items mean when they are typed."""
    search = {"batch_size": [64, 128], "net_arch": [[64, 64], [32]], "activation": ["relu", "tanh"]}
    values = {dimension.name: dimension.values for dimension in parse_space(search, sac, SAC)}
    assert values == {"batch_size": (64, 128), "net_arch": ((64, 64), (32,)), "activation": ("relu", "tanh")}


def test_default_is_learning_rate_and_gamma(sac):
    """Where nothing is said, these two are searched."""
    assert [dimension.name for dimension in parse_space({}, sac, SAC)] == ["learning_rate", "gamma"]


def test_dimension_reads_back_as_it_is_written(sac):
    """The text of a dimension means the dimension."""
    search = {"learning_rate": "1e-4..1e-2:log", "net_arch": "64x64|32", "train_freq": "1..8"}
    space = parse_space(search, sac, SAC)
    assert parse_space({dimension.name: dimension.text for dimension in space}, sac, SAC) == space


@pytest.mark.parametrize(
    ("search", "told"),
    [
        ({"lr": "1..2"}, "has no parameter 'lr'. There is: learning_rate, gamma"),
        ({"learning_rat": "1..2"}, "Did you mean 'learning_rate'?"),
        ({"gamma": "0.5..1.5"}, "gamma=1.5: Input should be less than or equal to 1"),
        ({"learning_rate": "0..1"}, "learning_rate=0.0: Input should be greater than 0"),
        ({"batch_size": "0|64"}, "batch_size=0: Input should be greater than 0"),
        ({"batch_size": "64|many"}, "batch_size=many: Input should be a valid integer"),
        ({"batch_size": "0.5..8"}, "'0.5' is not a whole number"),
        ({"batch_size": "64|64"}, "'64' is given twice"),
        ({"net_arch": "64x64|64x064"}, "'64x064' is given twice"),
        ({"net_arch": "64x64|0x64"}, "Input should be greater than 0"),
        ({"net_arch": "8..64"}, "net_arch is no number: write options"),
        ({"activation": "relu|gelu"}, "Input should be 'relu' or 'tanh'"),
        ({"gamma": "0.9"}, "one value is no search (--algo NAME:gamma=0.9 sets it): write gamma=LOW..HIGH, gamma="),
        ({"gamma": ""}, "search 'gamma=': it has no values: write gamma=LOW..HIGH"),
        ({"gamma": "0.9.."}, "the range has no upper end: write gamma=LOW..HIGH"),
        ({"gamma": "0.9..:log"}, "the range has no upper end"),
        ({"gamma": "..1"}, "the range has no lower end"),
        ({"gamma": ".."}, "the range has no lower and no upper end"),
        ({"gamma": "0.9|"}, "search 'gamma=0.9|': one of its options is empty: write gamma=LOW..HIGH"),
        ({"gamma": []}, "search 'gamma=': it has no option: write gamma=LOW..HIGH"),
        ({"gamma": "0.9..b"}, "'b' is not a number"),
        ({"gamma": "0.9..nan"}, "'nan' is not a number"),
        ({"gamma": "0.9..0.9"}, "ends before it begins"),
        ({"gamma": "0..0.9:log"}, "has to begin above 0"),
        ({"gamma": "0.1..0.9:lin"}, "'0.9:lin' is not a number"),
    ],
    ids=str,
)
def test_what_a_field_does_not_allow_is_refused(sac, search, told):
    """One line that says what was given and what is allowed."""
    with pytest.raises(UsageError) as refused:
        parse_space(search, sac, SAC)
    assert told in str(refused.value)


def test_nothing_to_search_names_what_there_is(toys):
    """An algorithm without learning rate and gamma has no default space."""
    target = toys.get("algorithms", "wander").load()
    with pytest.raises(UsageError, match=r"neither learning_rate nor gamma.*There is: then, width"):
        parse_space({}, target, "algorithm 'wander'")


def test_options_that_fail_beside_defaults_are_kept(toys):
    """What two fields refuse together is no matter of one field: a trial may set the other one too."""
    target = toys.get("algorithms", "sweep").load()
    (dimension,) = parse_space({"turns": "1..9"}, target, "algorithm 'sweep'")
    assert dimension == Range("turns", 1, 9, True, False)


@given(st.floats(1e-4, 1e-2))
def test_values_have_six_digits_and_stay_in_the_range(drawn):
    """What an algorithm gets is what a label shows."""
    value = Range("learning_rate", 1e-4, 1e-2, False, True).value(drawn)
    assert 1e-4 <= value <= 1e-2
    assert float(f"{value:g}") == value
    assert value == pytest.approx(drawn, rel=1e-5)


def test_a_value_is_located_where_the_space_holds_it():
    """As it would be drawn; None where it cannot be."""
    options = Options("net_arch", ("64x64", "32"), ((64, 64), (32,)))
    assert (options.locate((32,)), options.locate((8,))) == ("32", None)
    assert (Range("gamma", 0.9, 0.99, False, False).locate(0.95), Range("n", 1, 5, True, False).locate(6)) == (
        0.95,
        None,
    )
