"""What is tried: one number slipped by a factor, and files changed at random."""

import itertools
import math
from collections.abc import Callable, Iterator
from random import Random
from typing import Any, NamedTuple

from fuzz.inputs import Original, Place, leaves, number_of, of_other_commands, originals, with_number, with_value
from tests.helpers.settings import SHARED

FACTORS = (1e-6, 1e-3, 1e3, 1e6)
#: What a file is searched with: a train on several lines, a line by several trains; those of others where they are.
_PARTNERS = {
    "train": ("flat-100km", "lgv-100km", SHARED / "ttobench/tracks/CN_Songjiazhuang_Yizhuang.json"),
    "track": ("tgv", "alstom-emu", SHARED / "ttobench/trains/CN_Beijing_Subway.json"),
}
#: Of a list of rows these are slipped, as shares of its length: the first, the middle and the last one.
_ROWS = (0.0, 0.5, 1.0)
_VALUES = (0.0, -1.0, -0.0, 0.1, 1.0, 999.9, 1e-18, 1e-9, 1e9, 1e18, 1e308, math.inf, math.nan, None, True, "x", [], {})
#: Time that each search is told, s, and how.
TIME_LIMIT_S = 2.0
LIMITED = ("--time-limit", f"{TIME_LIMIT_S:g}")
#: What other commands are asked, by the kind of their file: one or two command lines.
_OTHERS = {
    "instance": (
        ("solve FILE --solver dp",), ("solve FILE --solver brute",), ("solve FILE --solver closed",),
        ("solve FILE --solver pt --sweeps 100 --reads 5",), ("formulate FILE --to lp -o out.lp",),
        ("formulate FILE --to coo --encoding unary -o out.coo",), ("formulate FILE --to qasm3 -o -",),
        ("bench FILE --solvers dp,random:unary:reads=5 --runs 1 --out out -q",),
    ),
    "run": (("score FILE --train alstom-emu --track flat-100km",),),
    "result": (("compare FILE FILE",),),
}  # fmt: skip
#: Options of a search with mutated files, and the share of searches that have one of them.
_SHARE_WITH_OPTIONS = 0.75
_OPTIONS = (
    "--energy pantograph", "--energy map", "--convention osrd", "--convention trainruns", "--reverse", "--wind 30",
    "--mass-model strip --curves roeckl --tunnels", "--at 3%,10%", "--clean", "--method best-first",
    "--method exact --segment 2000 --speeds 20",
)  # fmt: skip


Commands = tuple[tuple[str, ...], ...]


class Case(NamedTuple):
    """Command lines: a name that says what was changed, the file, and the commands that are given it in turn."""

    name: str
    file: str
    content: bytes
    commands: tuple[tuple[str, ...], ...]


def slips() -> Iterator[Case]:
    """Each number of each file by each factor; of rows with the same fields the first, the middle and the last."""
    for original in originals():
        partners = _partners(original)
        for number, place in enumerate(_slipped_places(original.tree)):
            for factor in FACTORS:

                def slip(table: Any, last: str | int, factor: float = factor) -> None:
                    table[last] = with_number(table[last], factor * (number_of(table[last]) or 0.0))

                name = f"{original.name}: {_text(place)} × {factor:g}"
                tree = with_value(original.tree, place, slip)
                commands = _search(original, partners[number % len(partners)], ())
                yield Case(name, original.name, _content(original, tree), commands)


def _slipped_places(tree: Any) -> Iterator[Place]:
    alike: dict[Place, list[Place]] = {}
    for place, value in leaves(tree):
        if number_of(value) is not None:
            is_row = [isinstance(step, int) and index < len(place) - 1 for index, step in enumerate(place)]
            alike.setdefault(tuple("*" if row else step for row, step in zip(is_row, place, strict=True)), []).append(
                place
            )
    for places in alike.values():
        yield from dict.fromkeys(places[round(share * (len(places) - 1))] for share in _ROWS)


def mutations(seed: int) -> Iterator[Case]:
    """Files with one to three things changed, searched, for ever."""
    return _mutations(f"{seed}", [originals()], _searched)


def loads(seed: int) -> Iterator[Case]:
    """Files with one to three things changed, only read and judged."""
    return _mutations(f"load {seed}", [originals()], lambda original, _: (("validate", "-v", original.name),))


def others(seed: int) -> Iterator[Case]:
    """What other commands read, with one to three things changed: lines of journeys, records, results, instances."""
    files = [*(original for original in originals() if original.kind == "track"), *of_other_commands()]
    by_kind: dict[str, list[Original]] = {}
    for original in files:
        by_kind.setdefault(original.kind, []).append(original)
    return _mutations(f"other {seed}", list(by_kind.values()), _other)


def _mutations(
    seed: str, pools: list[list[Original]], commands: Callable[[Original, Random], Commands]
) -> Iterator[Case]:
    """Each pool is drawn from as often as any other."""
    for index in itertools.count():
        random = Random(f"{seed}:{index}")
        original = random.choice(random.choice(pools))
        tree = original.tree
        for _ in range(random.randint(1, 3)):
            tree = _mutated(tree, random)
        content = _content(original, tree)
        if random.random() < 0.1:
            content = _damaged(content, random)
        yield Case(f"mutation {seed}:{index} of {original.name}", original.name, content, commands(original, random))


def _searched(original: Original, random: Random) -> Commands:
    options = tuple(random.choice(_OPTIONS).split()) if random.random() < _SHARE_WITH_OPTIONS else ()
    return _search(original, random.choice(_partners(original)), options)


def _other(original: Original, random: Random) -> Commands:
    file = original.name
    if original.kind == "track":
        journey = ("journey", "--track", file, "--train", random.choice(_partners(original)), "--points", "6")
        return ((*journey, "--no-pictures", *LIMITED),)
    return tuple(
        tuple(word.replace("FILE", file) for word in line.split()) for line in random.choice(_OTHERS[original.kind])
    )


def _mutated(tree: Any, random: Random) -> Any:
    """Change one number or value, or remove, double or swap rows."""
    places = list(leaves(tree))
    if not places:
        return tree
    place, value = random.choice(places)
    if not place:
        return tree
    action = random.choice(("scale", "scale", "scale", "column", "other", "value", "rows"))
    number = number_of(value)
    if number is not None and action in ("scale", "column"):
        factor = random.choice((*FACTORS, -1.0, 10.0 ** random.uniform(-3, 3), random.uniform(0.5, 2.0)))
        alike = _column(place, places) if action == "column" else [place]
        for other in alike:
            tree = with_value(tree, other, lambda table, last: _scale(table, last, factor))
        return tree
    if number is not None and action == "other":
        other = number_of(random.choice([one for _, one in places if number_of(one) is not None])) or 0.0
        return with_value(tree, place, lambda table, last: table.__setitem__(last, with_number(value, other)))
    if action == "rows" and len(place) > 1:
        return with_value(tree, place[:-1], lambda table, last: _change_rows(table, last, random))
    junk = random.choice(_VALUES)
    return with_value(
        tree, place, lambda table, last: table.__setitem__(last, str(junk) if isinstance(value, str) else junk)
    )


def _column(place: Place, places: list[tuple[Place, Any]]) -> list[Place]:
    """Places of what stands in the same column of the same table."""
    return [other for other, _ in places if (len(other), other[:1], other[-1]) == (len(place), place[:1], place[-1])]


def _scale(table: Any, last: str | int, factor: float) -> None:
    number = number_of(table[last])
    if number is not None:
        table[last] = with_number(table[last], factor * number)


def _change_rows(table: Any, last: str | int, random: Random) -> None:
    if not isinstance(table, list) or not isinstance(last, int):
        del table[last]
        return
    action, other = random.choice(("remove", "double", "swap")), random.randrange(len(table))
    if action == "remove":
        del table[last]
    elif action == "double":
        table.insert(other, table[last])
    else:
        table[last], table[other] = table[other], table[last]


def _damaged(content: bytes, random: Random) -> bytes:
    """Bytes replaced, removed or added somewhere."""
    at = random.randrange(len(content) + 1)
    return content[:at] + random.randbytes(random.randint(0, 3)) + content[at + random.randint(0, 3) :]


def _partners(original: Original) -> list[str]:
    known = _PARTNERS.get(original.kind, ("",))
    return [str(partner) for partner in known if isinstance(partner, str) or partner.is_file()]


def _content(original: Original, tree: Any) -> bytes:
    try:
        return original.write(tree).encode(errors="surrogatepass")
    except (TypeError, ValueError):  # TOML has no null: as a text
        return original.write(_without_none(tree)).encode(errors="surrogatepass")


def _search(original: Original, partner: str, options: tuple[str, ...]) -> Commands:
    """Read the file, then search with it; an energy map alone is nothing to validate."""
    file = original.name
    both = {"train": ("--train", file, "--track", partner), "track": ("--train", partner, "--track", file)}
    chosen = both.get(original.kind, ("--scenario", file))
    if original.kind == "map":
        chosen = ("--train", "alstom-emu", "--track", "flat-100km", "--energy", file)
        return (("search", *chosen, "--no-pictures", *LIMITED),)
    return ("validate", "-v", file), ("search", *chosen, *options, "--no-pictures", *LIMITED)


def _without_none(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _without_none(child) for key, child in tree.items()}
    if isinstance(tree, list):
        return [_without_none(child) for child in tree]
    return "none" if tree is None else tree


def _text(place: Place) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in place).removeprefix(".")
