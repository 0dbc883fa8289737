"""Whatever a slip of the pen does to a real file, it loads or is refused in one line: never a traceback."""

import copy
import json
import tomllib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from format_case import SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN
from tgvdp.errors import InputError
from tgvdp.formats import describe_file

TREES = {"train": TTOBENCH_TRAIN, "track": TTOBENCH_TRACK, "scenario": tomllib.loads(SCENARIO)}

JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(min_value=10**300, max_value=10**310),
    st.floats(),
    st.text(max_size=6),
    st.just([]),
    st.just({}),
    st.lists(st.floats() | st.text(max_size=3), max_size=3),
    st.dictionaries(st.text(max_size=5), st.floats(), max_size=2),
    st.sampled_from([-0.0, 0, 1e-320, 1e308, -1, "kN", "km/h", "infinity", "tgv", "m"]),
)


def places_of(tree, at=()):
    """Every place in a tree, as a path of keys and indices."""
    below = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for step, child in below:
        yield (*at, step)
        yield from places_of(child, (*at, step))


@st.composite
def mutated(draw, tree):
    """Replace, remove, rename or add one to three things."""
    tree = copy.deepcopy(tree)
    for _ in range(draw(st.integers(1, 3))):
        places = list(places_of(tree))
        if not places:
            return tree
        *above, last = draw(st.sampled_from(places))
        table = tree
        for step in above:
            table = table[step]
        action = draw(st.sampled_from(["replace", "replace", "remove", "rename", "add"]))
        if action == "replace":
            table[last] = draw(JUNK)
        elif action == "remove":
            del table[last]
        elif isinstance(table, dict):
            key = draw(st.text(max_size=8)) if action == "add" else f"{last}{draw(st.sampled_from('s_ x.[]`'))}"
            table[key] = table.pop(last) if action == "rename" else draw(JUNK)
        else:
            table.append(draw(JUNK))
    return tree


def refuses_or_loads(path, tree):
    """Write a tree, describe the file, and judge the error if there is one."""
    path.write_text(json.dumps(tree), encoding="utf-8")
    try:
        description = describe_file(path)
    except InputError as error:
        assert str(error).startswith(f"{path}: ")
        assert str(error).isprintable()
        assert len(str(error)) < 600 + len(str(path))
    else:
        assert str(description)


@pytest.mark.parametrize("kind", TREES)
def test_mutated_trees_load_or_are_refused_in_one_line(tmp_path, kind):
    path = tmp_path / "input.json"

    @settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
    @given(mutated(TREES[kind]))
    def check(tree):
        refuses_or_loads(path, tree)

    check()


@pytest.mark.parametrize("name", ["trains/CN_Beijing_Subway", "tracks/CN_Songjiazhuang_Yizhuang"])
def test_mutated_published_files_load_or_are_refused_in_one_line(shared, tmp_path, name):
    published = json.loads((shared / "ttobench" / f"{name}.json").read_text(encoding="utf-8"))

    @settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
    @given(mutated(published))
    def check(tree):
        refuses_or_loads(tmp_path / "input.json", tree)

    check()


@pytest.mark.parametrize("kind", TREES)
def test_mutated_bytes_load_or_are_refused_in_one_line(tmp_path, kind):
    path = tmp_path / "input"
    original = SCENARIO.encode() if kind == "scenario" else json.dumps(TREES[kind]).encode()

    @settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
    @given(st.integers(0, len(original)), st.integers(0, 20), st.binary(max_size=4))
    def check(at, length, instead):
        path.write_bytes(original[:at] + instead + original[at + length :])
        try:
            describe_file(path)
        except InputError as error:
            assert str(error).startswith(f"{path}: ")
            assert str(error).isprintable()

    check()


def test_the_unmutated_trees_are_valid(tmp_path):
    for kind, tree in TREES.items():
        path = tmp_path / f"{kind}.json"
        path.write_text(json.dumps(tree), encoding="utf-8")
        assert describe_file(path).kind == kind
