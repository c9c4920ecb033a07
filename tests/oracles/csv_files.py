"""The experimenters' CSV files as their two programs wrote them, other people's, and what may become of them.

Numbers are multiples of 1/32 m with few digits: they stand in the text exactly, and so do sums of them.
"""

import json
from dataclasses import dataclass

import pyarrow.parquet as pq

from tests.oracles.answers import Row, accelerated, etas, first_negative_and_crossover, indices
from tests.oracles.trial import Shown, Trial, call, call_json

HEADER = (
    "t", "beginDistance", "prevBest", "distance", "delta_distance", "reward", "target x", "target y", "target z",
    "endEff x ", "endEff y ", "endEff z ",
)  # fmt: skip
REWARD = HEADER.index("reward")
UNIT = 1 / 32


@dataclass
class Table:
    """A file before it is written; a change changes its cells."""

    header: list[str]
    rows: list[list[str]]

    @property
    def rewards(self):
        """What the text says, row by row."""
        place = [name.strip() for name in self.header].index("reward")
        return [float(row[place]) for row in self.rows]


def number(value):
    """As C# prints a float: seven digits, `1.192093E-07`."""
    return f"{value:.7g}".upper()


def draw_rows(rng, steps):
    """Episodes of an arm; now and then a target is touched and drawn anew."""
    rows = []
    begin = distance = 0.0
    while len(rows) < steps:
        if not rows or rng.random() < 0.05:
            begin = distance = UNIT * rng.randrange(8, 60)
            rows.append(Row(begin, distance, True))
            continue
        if rng.random() < 0.03:
            begin = UNIT * rng.randrange(8, 60)
            distance = begin
        distance = max(UNIT, min(62 * UNIT, distance + UNIT * rng.randrange(-6, 6)))
        rows.append(Row(begin, distance, False))
    return rows


def unity(rows, k1, k2, counts):
    """As the base line's program writes them, or as the other one does, which counts t."""
    paid = accelerated(rows, k1, k2)
    table, best, begin, time = [], 0.0, -1.0, 0
    for row, reward in zip(rows, paid, strict=True):
        time = 0 if row.is_start else time + 1
        if row.is_start or row.begin != begin:
            best = begin = row.begin
        before, best = best, min(best, row.distance)
        shown = best if counts else before
        delta = number(row.distance - before) if counts or row.is_start else ""
        cells = [str(time) if counts else "", *map(number, (row.begin, shown, row.distance)), delta, number(reward)]
        table.append([*cells, "0.45", "0.2", "0.45", number(-0.1857659), number(1.049303), number(row.distance)])
    return Table(list(HEADER), table)


def draw_group(rng, runs, steps, k2, counts):
    """Some runs of one reward."""
    return [unity(draw_rows(rng, steps), 1.0, k2, counts) for _ in range(runs)]


def plain(table):
    """The column of rewards alone, as other people have it."""
    return Table(["step", "reward"], [[str(place), row[REWARD]] for place, row in enumerate(table.rows)])


def text_of(table, newline="\n"):
    """The file."""
    return newline.join(",".join(cells) for cells in [table.header, *table.rows]) + newline


def answer_of(groups, with_steps=True):
    """What `harness eta` has to say of them."""
    rewards = [[table.rewards for table in group] for group in groups]
    steps = min(len(run) for group in rewards for run in group)
    rewards = [[run[:steps] for run in group] for group in rewards]
    eta_n, eta_p = etas(*rewards)
    told = {"eta_N": eta_n, "eta_P": eta_p}
    for name, group in zip(("baseline", "proposed"), rewards, strict=True):
        below, above = indices(group)
        first, crossover = first_negative_and_crossover(group)
        told[name] = {"I_N": Shown(below), "I_P": Shown(above)}
        told[name] |= {"first_negative": first, "crossover": crossover}
        told[name] |= {"steps": steps} if with_steps else {}
    return told


def write_groups(groups, folder, write):
    """A folder for each group."""
    for name, group in zip(("base", "prop"), groups, strict=True):
        (folder / name).mkdir(parents=True)
        for place, table in enumerate(group):
            write(table, folder / name / f"{place:02d}.csv")


def write_text(table, path):
    """As the program does."""
    path.write_text(text_of(table), newline="")


def ask(folder):
    """What `harness eta` says of both groups."""
    told, said = call_json("eta", "--baseline", f"{folder}/base/*", "--proposed", f"{folder}/prop/*")
    kept = ("I_N", "I_P", "first_negative", "crossover", "steps")
    return {
        "eta_N": told["eta_N"]["eta"]["value"],
        "eta_P": told["eta_P"]["eta"]["value"],
        **{name: {key: told[name][key] for key in kept} for name in ("baseline", "proposed")},
    }, said


def _groups(rng):
    steps, counts = rng.choice((3, 20, 90, 300)), rng.random() < 0.5
    groups = [draw_group(rng, rng.randrange(1, 5), steps, one, counts) for one in (1.0, rng.choice((1.0, 1.5, 2.0)))]
    return groups if rng.random() < 0.6 else [[plain(table) for table in group] for group in groups]


def no_matter(rng, folder):
    """The same numbers, written otherwise, under other names."""
    groups = _groups(rng)
    order = rng.choice((list, lambda names: names[::-1], sorted))
    style = rng.choice(STYLES)

    def write(table, path):
        places = [table.header.index(name) for name in order(list(table.header))]
        turned = Table(
            [table.header[place] for place in places], [[row[place] for place in places] for row in table.rows]
        )
        path.with_name(f"{rng.randrange(10**6)}-{path.name}").write_bytes(style(turned, rng))

    write_groups(groups, folder, write)
    return Trial(f"written as {style.__name__}", lambda: ask(folder), [answer_of(groups)])


def windows(table, rng):
    """Lines end as on Windows."""
    return text_of(table, "\r\n").encode()


def marked(table, rng):
    """Begins with the mark of UTF-8, and ends without a new line."""
    return text_of(table).rstrip("\n").encode("utf-8-sig")


def spelled(table, rng):
    """Numbers have more digits, signs and exponents; names have other cases and blanks."""

    def spell(cell):
        if not cell or cell.isdigit():
            return cell
        value = float(cell)
        return rng.choice((repr(value), f"{value:.12f}", f"{value:.9e}", f"{value:+.8f}"))

    header = [rng.choice((name, f" {name}", name.upper(), f"{name} ")) for name in table.header]
    return text_of(Table(header, [[spell(cell) for cell in row] for row in table.rows])).encode()


def wider(table, rng):
    """There are more columns, of words too."""
    place = rng.randrange(len(table.header) + 1)
    header = [*table.header[:place], "note", "loss", *table.header[place:]]
    rows = [[*row[:place], "é, quoted".join('""'), "", *row[place:]] for row in table.rows]
    return text_of(Table(header, rows)).encode()


def gaps(table, rng):
    """Empty lines stand at the end."""
    return (text_of(table) + "\n" * rng.randrange(1, 4)).encode()


STYLES = (windows, marked, spelled, wider, gaps)


def matters(rng, folder):
    """Other numbers: the answer is another, and follows."""
    groups = _groups(rng)
    change = rng.choice(CHANGES)
    change(groups, rng)
    write_groups(groups, folder, write_text)
    return Trial(change.__name__, lambda: ask(folder), [answer_of(groups)])


def _place(table):
    return [name.strip() for name in table.header].index("reward")


def move_value(groups, rng):
    """One reward is much larger, or smaller."""
    table = rng.choice(rng.choice(groups))
    rng.choice(table.rows)[_place(table)] = rng.choice(("1000", "-1000", "1.5E+04"))


def shift_column(groups, rng):
    """The rewards of a file stand a row later."""
    table = rng.choice(rng.choice(groups))
    rewards = [row[_place(table)] for row in table.rows]
    for row, reward in zip(table.rows, ["0", *rewards], strict=False):
        row[_place(table)] = reward


def swap_groups(groups, rng):
    """The base line is the other one."""
    groups.reverse()


def cut_rows(groups, rng):
    """All files end earlier."""
    steps = rng.randrange(1, len(groups[0][0].rows) + 1)
    for table in (table for group in groups for table in group):
        del table.rows[steps:]


def scale_proposed(groups, rng):
    """The proposed rewards are twice as large."""
    for table in groups[1]:
        for row in table.rows:
            row[_place(table)] = number(2 * float(row[_place(table)]))


CHANGES = (move_value, shift_column, swap_groups, cut_rows, scale_proposed)


def unequal(rng, folder):
    """Files of different lengths: cut to the common one and told, or refused."""
    groups = _groups(rng)
    group = rng.choice(groups)
    for table in group if rng.random() < 0.5 else [rng.choice(group)]:
        for _ in range(rng.randrange(1, 30)):
            table.rows.append(list(table.rows[-1]))
    write_groups(groups, folder, write_text)
    tells = r"(?i)left[ _]out|cut|budget|shorte|common"
    return Trial("unequal lengths", lambda: ask(folder), [answer_of(groups)], True, tells)


def damaged(rng, folder):
    """A file from which no number can be right: a damage changes the table, or gives what is written in its place."""
    groups = _groups(rng)
    damage = rng.choice(DAMAGES)
    which = (rng.randrange(2), 0)

    def write(table, path):
        is_chosen = (path.parent.name, path.name) == (("base", "prop")[which[0]], "00.csv")
        made = damage(table, rng) if is_chosen else None
        path.write_bytes(text_of(table).encode() if made is None else made)

    write_groups(groups, folder, write)
    return Trial(damage.__name__, lambda: ask(folder))


def odd_cell(table, rng):
    """A reward is no finite number."""
    rng.choice(table.rows)[_place(table)] = rng.choice(
        ("", "nan", "NaN", "inf", "-Infinity", "1e999", "0x10", "1_0", "None", "true", "1.5m", "--1", "1e", "٣", "½")
    )


def commas(table, rng):
    """Numbers with a decimal comma."""
    rng.choice(table.rows)[_place(table)] = "0,5"


def short_line(table, rng):
    """A line has a cell less, or one more."""
    row = rng.choice(table.rows)
    if rng.random() < 0.5:
        row.pop(0)
    else:
        row.insert(0, "1")


def two_rewards(table, rng):
    """Two columns are called reward."""
    table.header.append(rng.choice(("reward", " Reward ")))
    for row in table.rows:
        row.append("1")


def second_header(table, rng):
    """Two files joined, with both headers."""
    table.rows.insert(rng.randrange(1, len(table.rows) + 1), list(table.header))


def no_rows(table, rng):
    """A header alone, or nothing."""
    return rng.choice((text_of(Table(table.header, [])).encode(), b"", b"\n\n"))


def no_header(table, rng):
    """The first line is a row."""
    return text_of(Table(table.rows[0], table.rows[1:])).encode()


def semicolons(table, rng):
    """Another separator."""
    return text_of(table).replace(",", rng.choice((";", "\t", "|"))).encode()


def other_coding(table, rng):
    """UTF-16."""
    return text_of(table).encode("utf-16")


def pointer(table, rng):
    """What Git LFS leaves in a file's place."""
    return b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"4d" * 32 + b"\nsize 12345\n"


def episodes(table, rng):
    """Rows are episodes, not steps."""
    rows = [[str(place), row[_place(table)], str(rng.randrange(1, 200))] for place, row in enumerate(table.rows)]
    return text_of(Table(["episode", "reward", rng.choice(("length", "len", "steps"))], rows)).encode()


def monitor(table, rng):
    """stable-baselines3's Monitor."""
    head = json.dumps({"t_start": 1.5, "env_id": "Arm-v0"})
    rows = [f"{row[_place(table)]},20,{place}.5" for place, row in enumerate(table.rows)]
    return "\n".join([f"#{head}", "r,l,t", *rows, ""]).encode()


def binary(table, rng):
    """No text at all."""
    return b"\x89HDF\r\n\x1a\n" + bytes(rng.randrange(256) for _ in range(200))


DAMAGES = (
    odd_cell, odd_cell, commas, short_line, two_rewards, second_header, no_rows, no_header, semicolons, other_coding,
    pointer, episodes, monitor, binary,
)  # fmt: skip


def score(rng, folder):
    """A file is paid again by another reward."""
    k1, k2, counts = rng.choice((0.5, 1.0, 2.0)), rng.choice((1.0, 1.5, 3.0)), rng.random() < 0.5
    rows = draw_rows(rng, rng.choice((2, 30, 200)))
    table, style = unity(rows, 1.0, rng.choice((1.0, 2.0)), counts), rng.choice(STYLES)
    (folder / "a.csv").write_bytes(style(table, rng))
    right = {"arp": accelerated(rows, k1, k2), "baseline": accelerated(rows, 1.0, 1.0)}

    def pay():
        out, said = call("score", folder / "a.csv", "--reward", f"arp:k1={k1},k2={k2}", "--reward", "baseline")
        found = pq.read_table(next(folder.glob("*.scores.parquet"))).to_pydict()
        return {name.split(":")[0]: values for name, values in found.items()}, out + said

    return Trial(f"paid again, {style.__name__}", pay, [right])


ORACLES = {
    "csv, written otherwise": no_matter,
    "csv, other numbers": matters,
    "csv, unequal lengths": unequal,
    "csv, damaged": damaged,
    "csv, paid again": score,
}
