"""Lines of values: every value that a parser finds is found at the place where it is written."""

import json
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.scene.locate import Locations

KEYS = st.one_of(st.sampled_from(["a", "b", "shape", "radius", "1", "a-b"]), st.text(max_size=4))
SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(10**12), 10**12),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(alphabet=st.characters(codec="utf-8"), max_size=8),
    st.sampled_from(["# no comment", "[x]", 'a"b', "a'b", "a\\", "line\nline", "}", ","]),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(KEYS, inner, max_size=4)),
    max_leaves=12,
)
DOCUMENTS = st.dictionaries(KEYS, VALUES, max_size=5)

BLANKS = st.sampled_from(["", " ", "  ", "\t"])
NEWLINES = st.sampled_from(["\n", "\r\n", "\n\n", "  # comment with \" ' [ ] { } =\n", "\n# another\n"])


def leaves(data, path=()):
    """Every value in parsed data by its path."""
    if path:
        yield path, data
    if isinstance(data, dict):
        for key, value in data.items():
            yield from leaves(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from leaves(value, (*path, index))


@settings(deadline=None, derandomize=True)
@given(data=DOCUMENTS, indent=st.sampled_from([None, 0, 2]))
def test_every_value_of_json_is_found(data, indent):
    text = json.dumps(data, indent=indent, ensure_ascii=False)
    locations = Locations(text, is_json=True)
    assert locations.repeated == []
    for path, value in leaves(data):
        start, end = locations.spans[path]
        assert json.loads(text[start:end]) == value
        assert locations.line(path) == text[:start].count("\n") + 1


@st.composite
def toml_key(draw, key):
    plain = key and all(c.isascii() and (c.isalnum() or c in "-_") for c in key)
    if plain and draw(st.booleans()):
        return key
    if "'" not in key and key.isprintable() and draw(st.booleans()):
        return f"'{key}'"
    return json.dumps(key, ensure_ascii=False).replace("\x7f", "\\u007f")


@st.composite
def toml_string(draw, value):
    forms = [json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")]
    if value.isprintable():
        if "'" not in value:
            forms += [f"'{value}'", f"'''{value}'''", f"'''\n{value}'''"]
        if '"' not in value and "\\" not in value:
            forms += [f'"""{value}"""', f'"""\n{value}"""', f'"""{value}\\\n   """', f'"""{value}"""']
            forms += [f'""""{value}"""' if value else '""""""']
    return draw(st.sampled_from(forms))


@st.composite
def toml_value(draw, value):
    blank, newline = draw(BLANKS), draw(st.one_of(st.just(""), NEWLINES))
    if isinstance(value, dict):
        pairs = [f"{draw(toml_key(key))}{blank}={blank}{draw(toml_value(entry))}" for key, entry in value.items()]
        return "{" + blank + ", ".join(pairs) + blank + "}"
    if isinstance(value, list):
        entries = [draw(toml_value(entry)) for entry in value]
        comma = "," if entries and draw(st.booleans()) else ""
        return "[" + newline + f",{newline}".join(entries) + newline + comma + blank + "]"
    if isinstance(value, str):
        return draw(toml_string(value))
    return json.dumps(value)


@st.composite
def toml_texts(draw):
    data = draw(DOCUMENTS)
    newline = draw(NEWLINES)
    head, tail = [], []
    for key, value in data.items():
        name = draw(toml_key(key))
        if isinstance(value, dict) and draw(st.booleans()):
            tail.append(f"{draw(BLANKS)}[{draw(BLANKS)}{name}]")
            tail += [f"{draw(toml_key(inner))} = {draw(toml_value(entry))}" for inner, entry in value.items()]
        elif (
            isinstance(value, list)
            and value
            and all(isinstance(entry, dict) for entry in value)
            and draw(st.booleans())
        ):
            for entry in value:
                tail.append(f"[[{name}]]")
                plain = {inner: v for inner, v in entry.items() if not isinstance(v, dict)}
                tail += [f"{draw(toml_key(inner))} = {draw(toml_value(v))}" for inner, v in plain.items()]
                for inner, v in entry.items():
                    if isinstance(v, dict):
                        tail.append(f"[{name}.{draw(toml_key(inner))}]")
                        tail += [f"{draw(toml_key(leaf))} = {draw(toml_value(w))}" for leaf, w in v.items()]
        elif isinstance(value, dict) and value and draw(st.booleans()):
            head += [f"{name}.{draw(toml_key(inner))} = {draw(toml_value(entry))}" for inner, entry in value.items()]
        else:
            head.append(f"{name} = {draw(toml_value(value))}")
    return newline.join([*head, *tail]) + draw(st.sampled_from(["", "\n", " # end"]))


@settings(deadline=None, derandomize=True, max_examples=200)
@given(text=toml_texts())
def test_every_value_of_toml_is_found(text):
    data = tomllib.loads(text)
    locations = Locations(text, is_json=False)
    text = text.replace("\r\n", "\n")
    for path, value in leaves(data):
        start, end = locations.spans[path]
        assert locations.line(path) == text[:start].count("\n") + 1
        if not isinstance(value, dict | list):  # tables and arrays of tables may be spread over the text
            assert tomllib.loads(f"x = {text[start:end]}")["x"] == value


EXAMPLE = """\
# a comment with [brackets] and "quotes"
version = 1
title = '''
two
lines'''

[world]
gravity = [
  0, # x
  -9.81,
  0,
]
when = 1979-05-27 07:32:00

[[bodies]]
shape = { type = "sphere", radius = 0.5 }
"odd key" = 1
[[bodies]]
shape.type = "box"
shape.size = [1, [2, {a = 3}]]
  [bodies.extra]
  deep.er = true
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("version",), 2),
        (("title",), 3),
        (("world",), 7),
        (("world", "gravity"), 8),
        (("world", "gravity", 1), 10),
        (("world", "when"), 13),
        (("bodies", 0), 15),
        (("bodies", 0, "shape", "radius"), 16),
        (("bodies", 0, "odd key"), 17),
        (("bodies", 1), 18),
        (("bodies", 1, "shape"), 19),
        (("bodies", 1, "shape", "size", 1, 1, "a"), 20),
        (("bodies", 1, "extra"), 21),
        (("bodies", 1, "extra", "deep", "er"), 22),
        (("bodies", 1, "missing"), 18),
        (("bodies", 5), 15),
        (("nowhere",), 1),
    ],
)
def test_lines_of_an_example(path, line):
    assert Locations(EXAMPLE, is_json=False).line(path) == line


def test_keys_given_twice_in_json_are_found():
    assert Locations('{"a": {"b": 1, "b": 2}, "c": 1, "a": 3}', is_json=True).repeated == [("a", "b"), ("a",)]
