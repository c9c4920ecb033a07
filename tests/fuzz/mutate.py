"""Valid files made wrong: bytes that are changed, and values of another type or size put into trees."""

import copy
import json
import math
import tomllib
from xml.etree import ElementTree

import tomli_w

TOKENS = (
    b"\0", b"\xff", b"\xff\xfe", b"\xef\xbb\xbf", b"nan", b"-inf", b"1e400", b"-1", b"0", b"9" * 50, b"9" * 5_000,
    b"[" * 2_000, b"{" * 2_000, b"(" * 50, b",", b",," * 500, b":", b"=", b"\n", b"\r", b'"', b"'", b"<",
    b"&a;", b"<a>" * 200,
    b"\x1b[2J", "\u202e\u2028".encode(), b"a.b." * 500, b"../" * 50, b"%s%n", b"x" * 70_000, b" " * 5_000,
    b"\x00\x00\x00\x80", b"\xff\xff\xff\xff", b"\xff\xff\xff\xff\xff\xff\xff\x7f",
)  # fmt: skip
"""What breaks readers."""

VALUES = (
    None, True, False, 0, -1, 1, 2**31, 2**63, 10**30, -(10**30), 10**400, 0.5, -0.0, 1e300, 1e-320, 1e18, math.inf,
    -math.inf, math.nan, "", "x", "\0", "\u202e\x1b[2J", "a\nb", "../../x", "/dev/zero", "x" * 5_000, "nan", "1e400",
    "9" * 5_000, [], {}, [[]], [None], [1e300], [0] * 3_000, {"name": 7},
    {"name": "arp", "k1": {"a": {}}}, "a:b=c", "arp:k2=1e999",
)  # fmt: skip
"""What stands where something else belongs."""


def mutate_bytes(content, rng):
    """A few changes of bytes anywhere; sometimes nothing is left of what was."""
    if rng.random() < 0.03:
        return rng.randbytes(rng.randrange(2_000))
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 4, 16))):
        start = rng.randrange(len(data) + 1)
        end = min(len(data), start + rng.choice((1, 1, 4, 16, 200)))
        match rng.randrange(6):
            case 0:
                data[start:end] = rng.randbytes(end - start)
            case 1:
                del data[start:end]
            case 2:
                data[start:start] = data[start:end] * rng.choice((1, 2, 50))
            case 3:
                data[start:start] = rng.choice(TOKENS)
            case 4:
                data[start:end] = rng.choice(TOKENS)
            case _:
                if rng.random() < 0.2:
                    del data[start:]
                elif start < len(data):
                    data[start] ^= 1 << rng.randrange(8)
    return bytes(data)


def odd_value(rng):
    """One of `VALUES`, whose own stay what they are."""
    return copy.deepcopy(rng.choice(VALUES))


def mutate_tree(tree, rng):
    """Other values, other keys, parts that are missing or there twice."""
    changed = copy.deepcopy(tree)
    for _ in range(rng.choice((1, 1, 2, 4))):
        holders = [part for part in _walk(changed) if part]
        if not holders:
            return odd_value(rng)
        holder = rng.choice(holders)
        key = rng.choice(list(holder)) if isinstance(holder, dict) else rng.randrange(len(holder))
        match rng.randrange(8):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, dict):
                holder[rng.choice(("", "x", "name", "\u202e", "a" * 300))] = odd_value(rng)
            case 1:
                holder.append(odd_value(rng))
            case 2:
                other = rng.choice(holders)
                holder[key] = copy.deepcopy(rng.choice(list(other.values()) if isinstance(other, dict) else other))
            case 3:
                holder[key] = [holder[key]] * rng.choice((1, 2, 200))
            case 4:
                holder[key] = {"a": holder[key]}
            case _:
                holder[key] = odd_value(rng)
    return changed


def _walk(tree):
    """All lists and tables."""
    if isinstance(tree, dict):
        return [tree, *(part for value in tree.values() for part in _walk(value))]
    return [tree, *(part for value in tree for part in _walk(value))] if isinstance(tree, list) else []


def mutate_json(content, rng):
    """A JSON file with other values, or other bytes."""
    if rng.random() < 0.3:
        return mutate_bytes(content, rng)
    return json.dumps(mutate_tree(json.loads(content), rng)).encode()


def mutate_toml(content, rng):
    """A TOML file with other values, or other bytes."""
    if rng.random() < 0.3:
        return mutate_bytes(content, rng)
    try:
        return tomli_w.dumps(mutate_tree(tomllib.loads(content.decode()), rng)).encode(errors="surrogatepass")
    except (TypeError, ValueError, AttributeError, RecursionError):  # what TOML has no word for
        return mutate_bytes(content, rng)


def mutate_xml(content, rng):
    """An XML file with other attributes, elements that are missing, there twice or elsewhere; or other bytes."""
    if rng.random() < 0.3:
        return mutate_bytes(content, rng)
    root = ElementTree.fromstring(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        elements = list(root.iter())
        element = rng.choice(elements)
        match rng.randrange(6):
            case 0 if len(element):
                element.remove(rng.choice(element))
            case 1:
                element.append(copy.deepcopy(rng.choice(elements)))
            case 2 if len(element):
                element[:] = list(element) * rng.choice((2, 30))
            case 3:
                element.tag = rng.choice(elements).tag
            case _ if element.attrib:
                element.set(rng.choice(list(element.attrib)), _attribute(elements, rng))
            case _:
                element.set(rng.choice(("name", "type", "xyz", "lower")), _attribute(elements, rng))
    return ElementTree.tostring(root, encoding="unicode").encode(errors="surrogatepass")


def _attribute(elements, rng):
    """Odd text, or that of another attribute."""
    if rng.random() < 0.4:
        return rng.choice([value for element in elements for value in element.attrib.values()] or ["x"])
    value = str(rng.choice(VALUES[:-8])).replace("\0", "").replace("\x1b", "")
    return " ".join([value] * rng.choice((1, 1, 3, 6)))


def mutate_csv(content, rng):
    """A table with other cells, or other bytes."""
    if rng.random() < 0.4:
        return mutate_bytes(content, rng)
    rows = [line.split(b",") for line in content.splitlines()]
    for _ in range(rng.choice((1, 1, 3))):
        row = rng.choice(rows)
        row[rng.randrange(len(row))] = str(rng.choice(VALUES)).encode(errors="surrogatepass")
    return b"\n".join(b",".join(row) for row in rows)


def mutate_text(content, rng):
    """The text of a name with parameters: other characters, and values that no parameter has."""
    text = content.decode()
    if rng.random() < 0.6 and "=" in text:
        parts = text.split("=")
        parts[rng.randrange(1, len(parts))] = str(rng.choice(VALUES))
        text = "=".join(parts)
    else:
        text = mutate_bytes(content, rng).decode(errors="replace")
    return text.encode(errors="surrogatepass")
