"""What a user picks: names with parameters, in text and in tables."""

import json

import pytest
from hypothesis import example, given, settings, strategies as st

from harness import load_registry
from harness.errors import UsageError
from harness.registry import Choice, build_defaults, choose, parse, split_list
from harness.registry.choice import build_named

NAMES = st.from_regex(r"[a-z0-9][a-z0-9_-]{0,8}", fullmatch=True)
KEYS = st.from_regex(r"[a-z_][a-z0-9_]{0,6}", fullmatch=True)
VALUES = st.from_regex(r"[A-Za-z0-9.+-]{1,8}", fullmatch=True)
PICKS = st.tuples(NAMES, st.dictionaries(KEYS, VALUES, max_size=3))
NESTED = st.recursive(
    VALUES, lambda inner: st.tuples(NAMES, st.dictionaries(KEYS, inner, min_size=1, max_size=3)), max_leaves=6
)

FEWER = settings(max_examples=50)
"""Texts that match patterns take long to draw."""


def _write(pick):
    name, params = pick
    return name + (":" + ",".join(f"{key}={value}" for key, value in params.items()) if params else "")


def test_parse(subtests):
    """A name, and after a colon its parameters; blanks around them mean nothing."""
    rows = [
        ("arp", ("arp", {})),
        ("arp:k2=2", ("arp", {"k2": "2"})),
        ("arp:k1=1,k2=1.5", ("arp", {"k1": "1", "k2": "1.5"})),
        (" arp : k1 = 1 , k2 = 2 ", ("arp", {"k1": "1", "k2": "2"})),
        ("a:url=b=c", ("a", {"url": "b=c"})),
        ("a:b=c:d=1,e=2", ("a", {"b": "c:d=1", "e": "2"})),
        ("a:b=(c:d=1,e=2),f=3", ("a", {"b": "c:d=1,e=2", "f": "3"})),
        ("a:b=(c:d=1,e=(f:g=2,h=3)),i=4", ("a", {"b": "c:d=1,e=(f:g=2,h=3)", "i": "4"})),
        ("a:b=x(1)", ("a", {"b": "x(1)"})),
    ]
    for text, parsed in rows:
        with subtests.test(text=text, parsed=parsed):
            assert parse(text) == parsed


def test_malformed_text_is_refused_in_one_line(subtests):
    """The message repeats what was given and shows how to write it."""
    for text in ["", ":", "arp:", ":k=1", "arp:k2", "arp:k2=", "arp:=2", "arp:k1=1,", "k2=2", "arp:,"]:
        with subtests.test(text=text):
            with pytest.raises(UsageError, match="write name or name:key=value,key=value") as error:
                parse(text)
            assert f"'{text}'" in str(error.value)
            assert "\n" not in str(error.value)


@pytest.mark.parametrize("text", ["a:b=(c:d=1,e=2", "a:b=c:d=1,e=2)", "a(:b=1"])
def test_parenthesis_without_its_counterpart_is_refused(text):
    """Where the named thing's parameters end is not guessed."""
    with pytest.raises(UsageError, match="is malformed: write name or name:key=value,key=value"):
        parse(text)


def test_parameter_given_twice_is_refused():
    """Neither value wins."""
    with pytest.raises(UsageError, match="'k2' is given twice in 'arp:k2=1,k2=2'"):
        parse("arp:k2=1,k2=2")


def test_comma_starts_a_new_name_unless_key_value_follows(subtests):
    """`key=value` belongs to the name before it, within one flag; what is in parentheses stays together."""
    rows = [
        ("mujoco", ["mujoco"]),
        ("a,b", ["a", "b"]),
        ("a, b", ["a", "b"]),
        ("a,b:x=1,y=2,c", ["a", "b:x=1,y=2", "c"]),
        ("a:x=1,b:y=2,z=3", ["a:x=1", "b:y=2,z=3"]),
        (["a,b", "c:x=1,y=2"], ["a", "b", "c:x=1,y=2"]),
        (["a:x=1", "y=2"], ["a:x=1", "y=2"]),
        ("a,x=1", ["a", "x=1"]),
        ("scaled:reward=arp:k2=2,factor=3", ["scaled:reward=arp:k2=2,factor=3"]),
        ("baseline,scaled:reward=baseline,factor=2,arp", ["baseline", "scaled:reward=baseline,factor=2", "arp"]),
        ("scaled:factor=2,reward=arp:k2=2,arp:k2=2", ["scaled:factor=2,reward=arp:k2=2", "arp:k2=2"]),
        ("a:b=(c:d=1,e=2),f=3,g", ["a:b=(c:d=1,e=2),f=3", "g"]),
        ("a,b:c=(d,e),f", ["a", "b:c=(d,e)", "f"]),
    ]
    for typed, names in rows:
        with subtests.test(typed=typed, names=names):
            assert split_list(typed) == names


@FEWER
@given(st.lists(PICKS, min_size=1, max_size=4))
def test_joined_names_come_apart_again(picks):
    """Whatever names and parameters are joined by commas, they are split and parsed as they were."""
    assert [parse(text) for text in split_list(",".join(map(_write, picks)))] == picks


@FEWER
@given(st.lists(st.tuples(NAMES, st.dictionaries(KEYS, NESTED, max_size=3)), min_size=1, max_size=4))
def test_names_inside_names_come_apart_again(picks):
    """Each level of parentheses is one text for the level around it, however deep."""

    def write(value):
        return value if isinstance(value, str) else f"({write_pick(value)})"

    def write_pick(pick):
        return _write((pick[0], {key: write(value) for key, value in pick[1].items()}))

    def read(text, like):
        if isinstance(like, str):
            return text
        name, params = parse(text)
        return name, {key: read(value, like[1][key]) for key, value in params.items()}

    texts = split_list(",".join(map(write_pick, picks)))
    assert [read(text, pick) for text, pick in zip(texts, picks, strict=True)] == picks


def test_text_and_table_are_the_same_choice(registry):
    """`arp:k2=2` on the command line is `{name = "arp", k2 = 2}` in a file."""
    assert choose(registry, "rewards", "arp:k2=2") == choose(registry, "rewards", {"name": "arp", "k2": 2})


def test_choice_holds_every_parameter(registry):
    """Defaults are written out, in the order of the fields, each in its own type."""
    assert choose(registry, "rewards", "arp:k2=2").params == (("k1", 1.0), ("k2", 2.0))


@pytest.mark.parametrize(("text", "params"), [("arp", (("k1", 1.0),)), ("arp:k2=2", (("k1", 1.0), ("k2", 2.0)))])
def test_later_parameter_counts_where_it_is_not_at_its_default(registry, monkeypatch, text, params):
    """A parameter that an earlier version did not have leaves the cells of that version what they were."""
    monkeypatch.setattr(registry.get("rewards", "arp").load(), "later", ("k2",), raising=False)
    assert choose(registry, "rewards", text).params == params


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("arp", "arp"),
        ("arp:k1=1,k2=1.5", "arp"),
        ("arp:k2=2", "arp:k2=2"),
        ("arp:k2=2.50,k1=3", "arp:k1=3,k2=2.5"),
        ("arp:k2=1.23456789", "arp:k2=1.23456789"),
    ],
)
def test_label_says_what_differs_from_the_defaults(registry, text, label):
    """A parameter at its default is not said, and the order of the flags does not matter."""
    assert choose(registry, "rewards", text).label == label


@given(st.floats(min_value=1e-300, max_value=1e18), st.floats(min_value=1e-300, max_value=1e18))
@example(1.0, 1.2345678)
def test_label_is_the_choice_again(registry, k1, k2):
    """Different parameters never share a label: typed again, it gives the same choice."""
    choice = choose(registry, "rewards", {"name": "arp", "k1": k1, "k2": k2})
    assert choose(registry, "rewards", choice.label) == choice


def test_label_of_a_tuple(registry):
    """The items of a tuple are joined as they are typed."""
    choice = choose(registry, "tasks", "fd100-reach:target_center=0.5x-0.1x1e-3")
    assert choice.label == "fd100-reach:target_center=0.5x-0.1x0.001"
    assert dict(choice.params)["target_center"] == (0.5, -0.1, 0.001)


def test_parameter_that_a_name_has_not_belongs_to_the_name_inside(registry):
    """`scaled` has no k2 and `arp` has; with parentheses there is nothing to find out."""
    bare = choose(registry, "rewards", "scaled:reward=arp:k1=2,k2=3,factor=4")
    assert dict(bare.params) == {"reward": "arp:k1=2,k2=3", "factor": 4.0}
    assert bare == choose(registry, "rewards", "scaled:reward=(arp:k1=2,k2=3),factor=4")


@given(k1=st.floats(0.01, 100.0), k2=st.floats(0.01, 100.0), factor=st.floats(0.01, 100.0))
def test_label_of_a_name_inside_a_name_is_the_choice_again(registry, k1, k2, factor):
    """Commas of the inner name are in parentheses."""
    table = {"name": "scaled", "reward": f"shifted:reward=(arp:k1={k1},k2={k2}),offset={k1}", "factor": factor}
    choice = choose(registry, "rewards", table)
    assert choose(registry, "rewards", choice.label) == choice


@pytest.mark.parametrize("text", ["arp:k2=2", "baseline", "scaled:reward=(arp:k1=2,k2=3),factor=4"])
def test_choice_survives_json(registry, text):
    """Written as JSON text and read again it is equal, and hashes alike."""
    choice = choose(registry, "rewards", text)
    again = Choice.from_json(json.loads(json.dumps(choice.to_json())))
    assert again == choice
    assert hash(again) == hash(choice)


@FEWER
@given(st.dictionaries(KEYS, st.recursive(st.integers() | st.text() | st.none(), st.lists), max_size=3))
def test_any_parameters_survive_json(params):
    """Nested tuples come back as tuples."""

    def frozen(value):
        return tuple(map(frozen, value)) if isinstance(value, list) else value

    choice = Choice("name", tuple((key, frozen(value)) for key, value in params.items()), "label")
    assert Choice.from_json(json.loads(json.dumps(choice.to_json()))) == choice


def test_choice_builds_what_was_chosen(registry):
    """The registered target, with the parameters of the choice."""
    built = choose(registry, "rewards", "arp:k2=2").build(registry, "rewards")
    assert (type(built).__name__, built.k1, built.k2) == ("Arp", 1.0, 2.0)


REFUSED = {
    "unknown name": ("apr", "No reward 'apr'. There is: aarp, adaptive, arp, "),
    "unknown parameter": ("arp:k22=1", "Reward 'arp' has no parameter 'k22'. There is: k1, k2. Did you mean 'k2'?"),
    "parameter of a name without any": ("baseline:k=1", "Reward 'baseline' has no parameter 'k'. There is: none."),
    "wrong type": ("arp:k2=two", "Reward 'arp': k2='two': Input should be a valid number"),
    "out of range": ("arp:k2=0", "Reward 'arp': k2='0': Input should be greater than 0"),
    "not finite": ("arp:k2=inf", "Reward 'arp': k2='inf': Input should be a finite number"),
}


def test_what_cannot_be_chosen_is_refused_in_one_line(registry, subtests):
    """The message says what was given and what there is."""
    for case, (text, message) in REFUSED.items():
        with subtests.test(case):
            with pytest.raises(UsageError) as error:
                choose(registry, "rewards", text)
            assert str(error.value).startswith(message)
            assert "\n" not in str(error.value)


def test_unknown_name_is_told_with_the_nearest(registry):
    """After all that there is."""
    with pytest.raises(UsageError, match=r"No reward 'apr'\. .*, sparse\. Did you mean 'arp'\?$"):
        choose(registry, "rewards", "apr")


def test_table_without_a_name_is_refused(registry):
    """A file's table has to say which one it means."""
    with pytest.raises(UsageError, match=r"\{'k2': 2\} has no name: write \{name = '...', key = value\}"):
        choose(registry, "rewards", {"k2": 2})


def test_build_named_gives_label_and_thing(registry):
    """For plugins that build on another of their kind."""
    label, reward = build_named(registry, "rewards", " arp : k2 = 2.0 ", within="mine")
    assert label == "arp:k2=2"
    assert (type(reward).__name__, reward.k2) == ("Arp", 2.0)


@pytest.mark.parametrize(
    "text", ["mine", "mine:reward=arp", "scaled:reward=mine", "scaled:factor=2,reward=(mine:a=1,b=2)"]
)
def test_build_named_refuses_the_name_inside_itself(registry, text):
    """Also through another one that builds on it; whether it is installed does not matter."""
    with pytest.raises(UsageError, match=r"Reward 'mine' is given '.*': it cannot stand inside itself"):
        build_named(registry, "rewards", text, within="mine")


FLOAT = """
import harness
from dataclasses import dataclass

@harness.hookimpl
def register_rewards(register):
    register("mine", __name__ + ":Mine", summary="")

@dataclass(frozen=True)
class Mine:
    k: float = 1

    def initial_carry(self, begin_distance): ...
    def __call__(self, carry, sample): ...
"""


def test_default_and_its_text_are_one_choice(write_plugin):
    """A default written as 1 where a float is declared, and `k=1`, make choices with the same JSON text."""
    registry = load_registry([write_plugin(FLOAT, "float")])
    texts = [json.dumps(choose(registry, "rewards", text).to_json()) for text in ("mine", "mine:k=1")]
    assert texts[0] == texts[1]
    assert '"k": 1.0' in texts[0]


def test_defaults_of_a_kind_are_built_by_name(toys):
    """All that are registered, or those that are named, each with the parameters that it has by itself."""
    every = build_defaults(toys, "metrics")
    assert list(every) == toys.names("metrics")
    assert build_defaults(toys, "metrics", ["success_rate"]) == {"success_rate": every["success_rate"]}


def test_default_of_an_unknown_name_is_refused(toys):
    """As any other name."""
    with pytest.raises(UsageError, match="Did you mean 'success_rate'"):
        build_defaults(toys, "metrics", ["sucess_rate"])


@pytest.mark.parametrize("text", ["a:b=1" + ",b=1" * 100_000, "(" * 20_000 + ")" * 20_000])
def test_a_long_text_is_refused_at_once(text):
    """To take it apart would take minutes."""
    with pytest.raises(UsageError, match="10,000 are allowed"):
        split_list(text)
    with pytest.raises(UsageError, match="10,000 are allowed"):
        parse(text)


@pytest.mark.parametrize("label", ["arp\nThe robot: HELPS", "arp\r", 7, None])
def test_a_label_of_several_lines_is_none(label):
    """In a file that says so it would be taken for lines of ours."""
    with pytest.raises(ValueError, match="is no name"):
        Choice.from_json({"name": "arp", "label": label, "params": {}})
