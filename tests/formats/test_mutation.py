"""Whatever a slip of the pen does to a file, it loads or is refused in one line with its place: never a traceback."""

import json
import time
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.format_case import JOURNEY, SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN, TTOBENCH_TRAIN_14, yaml_text
from tests.helpers.osrd_case import OSRD_PATH, OSRD_SCHEDULE, OSRD_TRAIN
from tests.helpers.railtoolkit_case import PATHS, PATHS_2024, ROLLING_STOCK
from tests.helpers.settings import SHARED, fuzz
from tgvdp.errors import InputError
from tgvdp.formats import describe_file
from tgvdp.formats.syntax.reading import LARGEST_BYTES, field_text
from tgvdp.formats.syntax.yaml import parse_yaml

TREES = {
    "train": TTOBENCH_TRAIN,
    "train 1.4": TTOBENCH_TRAIN_14,
    "track": TTOBENCH_TRACK,
    "journey": JOURNEY,
    "scenario": tomllib.loads(SCENARIO),
    "railtoolkit stock": ROLLING_STOCK,
    "railtoolkit paths": PATHS,
    "railtoolkit paths 2024": PATHS_2024,
    "OSRD": OSRD_TRAIN,
    "OSRD path": OSRD_PATH,
    "OSRD schedule": OSRD_SCHEDULE,
}
TEXTS = {kind: json.dumps(tree) for kind, tree in TREES.items()} | {
    "scenario": SCENARIO,
    "railtoolkit stock": yaml_text(ROLLING_STOCK),
    "railtoolkit paths": yaml_text(PATHS),
}
PUBLISHED = {
    "train": ["ttobench/trains/CN_Beijing_Subway.json", "ttobench/trains/CH_Stadler_KISS_SBB.json"],
    "track": ["ttobench/tracks/CN_Songjiazhuang_Yizhuang.json"],
    "journey": ["ttobench/journeys/CH_StGallen_Wil_Journey_01.json"],
    "railtoolkit stock": ["railtoolkit/trains/local.yaml"],
    "railtoolkit paths": ["railtoolkit/paths/slope.yaml", "railtoolkit/paths/speed.yaml"],
    "OSRD": ["osrd/electric_rolling_stock.json", "osrd/fast_rolling_stock.json"],
}
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
    st.text(st.characters(categories=["Cs", "Cc"]), min_size=1, max_size=2),
    st.sampled_from([-0.0, 0, 1e-320, 1e308, -1, "kN", "km/h", "infinity", "tgv", "m", "2022.05"]),
)


def with_change(tree, place, change):
    """Copy a tree along one place only, where a function changes the table or list that holds it."""
    if len(place) == 1:
        copy = dict(tree) if isinstance(tree, dict) else list(tree)
        change(copy, place[0])
        return copy
    return with_change(
        tree, place[:1], lambda copy, step: copy.__setitem__(step, with_change(copy[step], place[1:], change))
    )


@st.composite
def places_in(draw, tree):
    """A place in a tree, near its top more often than in the depth of a table."""
    place = []
    while isinstance(tree, dict | list) and tree and (not place or draw(st.booleans())):
        place.append(draw(st.sampled_from(list(tree) if isinstance(tree, dict) else range(len(tree)))))
        tree = tree[place[-1]]
    return tuple(place)


@st.composite
def mutated(draw, tree):
    """Replace, remove, rename or add one to three things."""
    for _ in range(draw(st.integers(1, 3))):
        place = draw(places_in(tree))
        if not place:
            return tree
        action = draw(st.sampled_from(["replace", "replace", "remove", "rename", "add"]))
        junk, suffix = draw(JUNK), draw(st.sampled_from(["s", "_", " ", "x", ".", "[", "]", "`"]))

        def change(table, last, action=action, junk=junk, suffix=suffix):
            if action == "replace":
                table[last] = junk
            elif action == "remove":
                del table[last]
            elif isinstance(table, list):
                table.append(junk)
            elif action == "rename":
                table[f"{last}{suffix}"] = table.pop(last)
            else:
                table[suffix] = junk

        tree = with_change(tree, place, change)
    return tree


def refused_or_loaded(path):
    """Describe a file; judge the error if there is one, and return it."""
    try:
        description = describe_file(path)
    except InputError as error:
        line = str(error)
        assert line.startswith(f"{path}: ")
        assert line.isprintable()
        assert len(line) < 700 + len(str(path))
        assert not line.endswith("known: ")
        return line.removeprefix(f"{path}: ")
    assert str(description)
    return None


def published_trees(kind):
    """Files of others that are read the same way, where the folder beside the project holds them."""
    for path in (SHARED / name for name in PUBLISHED.get(kind, ()) if SHARED.is_dir()):
        text = path.read_text(encoding="utf-8")
        yield json.loads(text) if path.suffix == ".json" else parse_yaml(text)[0]


@pytest.mark.parametrize("kind", TREES)
def test_mutated_trees_load_or_are_refused_in_one_line(tmp_path, kind):
    path = tmp_path / "input.json"
    trees = [TREES[kind], *published_trees(kind)]

    @fuzz()
    @given(st.sampled_from(trees).flatmap(mutated))
    def check(tree):
        path.write_text(json.dumps(tree), encoding="utf-8")
        refused_or_loaded(path)

    check()


@pytest.mark.parametrize("kind", TEXTS)
def test_mutated_bytes_load_or_are_refused_in_one_line(tmp_path, kind):
    original, path = TEXTS[kind].encode(), tmp_path / "input"

    @fuzz(100)
    @given(st.integers(0, len(original)), st.integers(0, 20), st.binary(max_size=4))
    def check(at, length, instead):
        path.write_bytes(original[:at] + instead + original[at + length :])
        refused_or_loaded(path)

    check()


def leaves_of(tree, at=()):
    """Every number and text in a tree, as a path of keys and indices."""
    for step, child in tree.items() if isinstance(tree, dict) else enumerate(tree):
        if isinstance(child, dict | list):
            yield from leaves_of(child, (*at, step))
        else:
            yield (*at, step)


@pytest.mark.parametrize("kind", TREES)
def test_a_wrong_value_is_refused_with_its_place(tmp_path, kind):
    """A table in place of a number or text; some are free text, and a few are judged with what stands around them."""
    path, named = tmp_path / "input.json", 0
    for place in leaves_of(TREES[kind]):
        wrong = with_change(TREES[kind], place, lambda table, last: table.__setitem__(last, {"wrong": 1}))
        path.write_text(json.dumps(wrong), encoding="utf-8")
        line = refused_or_loaded(path)
        if line is not None:
            assert line.startswith(tuple(field_text(place[:end]) for end in range(len(place), 0, -1))), line
            named += line.startswith(field_text(place))
    assert named >= 10


def test_the_unmutated_trees_are_valid(tmp_path):
    for tree in TREES.values():
        path = tmp_path / "input.json"
        path.write_text(json.dumps(tree), encoding="utf-8")
        assert refused_or_loaded(path) is None


BOMBS = {
    "deep JSON": '{"a":' * 1_000_000,
    "deep lists": '{"a":' + "[" * 1_000_000,
    "deep TOML": "a = " + "[" * 1_000_000,
    "infinite": '{"railjson_version": 1e999}',
    "not a number": '{"railjson_version": NaN}',
    "integer": '{"railjson_version": 1' + "0" * 1_000_000 + "}",
    "twice": '{"railjson_version": "3.2", "railjson_version": "3.3"}',
    "keys": "{" + ",".join(f'"k{n}": 1' for n in range(100_000)) + "}",
    "numbers": '{"railjson_version": [' + "1," * 500_000 + "1]}",
    "huge": " " * (LARGEST_BYTES + 1),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_are_refused_within_a_second(tmp_path, kind):
    path = tmp_path / "bomb"
    path.write_text(BOMBS[kind])
    started = time.process_time()
    assert refused_or_loaded(path) is not None
    assert time.process_time() - started < 1.0
