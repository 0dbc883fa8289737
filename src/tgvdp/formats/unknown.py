"""What a file may be that is of no format: the spec of a sweep, or one with a slip of the pen."""

from difflib import get_close_matches

from tgvdp.formats.syntax.reading import Document, bad, shown

#: Fields of the spec of a sweep, beside ``run``, that files of trains and lines do not have.
SWEEP_FIELDS = frozenset({"trains", "lines", "sections", "product", "zip"})
#: Fields of every instance of the formulations, and how the schema of what tgvdp writes begins.
_INSTANCE, _OWN = frozenset({"id", "params"}), "tgvdp."
_FEWEST_FIELDS = 2  # one alone may be a slip of the pen
_LOOKED_AT = 20  # fields in which one is looked for


def is_sweep(document: Document) -> bool:
    """Whether a document is meant as the spec of a sweep, be it right or wrong."""
    fields = document.tree.keys()
    return not fields & {"train", "track", "map"} and len(fields & SWEEP_FIELDS) >= _FEWEST_FIELDS


def require_known_content(document: Document) -> None:
    """Say what was expected when nothing at the top of a file is known; a slip beside known fields shows later.

    Raises
    ------
    InputError
        When none is, or the file is one that only a command of its own takes.
    """
    if is_sweep(document):
        raise bad(document.path, "is the spec of a sweep, which tgvdp sweep runs")
    fields = document.tree.keys()
    if fields & {"train", "track", "map", "run"}:
        return
    if fields >= _INSTANCE:
        raise bad(document.path, "is an instance of the formulations, which tgvdp solve takes")
    schema = document.tree.get("schema")
    if isinstance(schema, str) and schema.startswith(_OWN):
        raise bad(document.path, f"is a result of tgvdp, {shown(schema)}, and no train or line")
    if "metadata" in fields:
        raise bad(document.path, "is no TTOBench train, track or journey: it has none of their fields")
    known = ["train", "track", "map", "run"]
    near = [match for name in list(fields)[:_LOOKED_AT] for match in get_close_matches(name.lower(), known, n=1)]
    hint = f", did you mean {near[0]!r}?" if near else ""
    got = ", ".join(repr(name)[:40] for name in list(fields)[:3]) or "nothing"
    foreign = "TTOBench, railtoolkit and OSRD"
    raise bad(document.path, f"holds none of train, track, map and run, nor what {foreign} files hold, got {got}{hint}")
