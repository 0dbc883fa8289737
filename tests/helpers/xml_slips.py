"""Slips of the pen in XML: attributes and elements that are changed, renamed, doubled or gone, and what follows."""

import re

from hypothesis import strategies as st

from tgvdp.errors import InputError
from tgvdp.formats import describe_file

JUNK = st.one_of(
    st.sampled_from(
        ["", " ", "-1", "0", "1e999", "NaN", "INF", "1e308", "-1e308", "1e-320", "end", "999.9", "both", "down", "true",
         "t1", "ne1", "ne2", "loco", "coach", "kN", "N/kN", "m/s", "1e6", "up", "99999999999999999999", "&amp;"]
    ),
    st.floats().map(str),
    st.integers().map(str),
    st.text(alphabet=st.characters(codec="utf-8", exclude_characters='<>&"', min_codepoint=32), max_size=8),
)  # fmt: skip

ATTRIBUTE = re.compile(r' [A-Za-z]+="[^"]*"')
ELEMENT = re.compile(r"<([A-Za-z]+)[^<>]*/>|<([A-Za-z]+)[^<>]*>(?:(?!</?\2[ >]).)*?</\2>", re.DOTALL)


@st.composite
def mutated(draw, text):
    """Change, remove, rename or double attributes, and remove, double or rename elements, one to three times."""
    for _ in range(draw(st.integers(1, 3))):
        on_attribute = draw(st.booleans())
        found = list((ATTRIBUTE if on_attribute else ELEMENT).finditer(text))
        if not found:
            return text
        match = draw(st.sampled_from(found))
        old = match[0]
        if on_attribute:
            name = old.partition("=")[0]
            new = draw(st.one_of(JUNK.map(lambda junk, name=name: f'{name}="{junk}"'), st.just("")))
        else:
            name = match[1] or match[2]
            new = draw(st.sampled_from(["", old + old, old.replace(name, "other"), f"<other>{old}</other>"]))
        text = text[: match.start()] + new + text[match.end() :]
    return text


def loads_or_is_refused(path, data, whole_file):
    """A file of some bytes is described, or refused in one line that has its place or begins as of a whole file."""
    path.write_bytes(data)
    try:
        description = describe_file(path)
    except InputError as error:
        line = str(error)
        assert line.startswith(f"{path}: ")
        assert line.isprintable()
        assert len(line) < 800 + len(str(path))
        rest = line.removeprefix(f"{path}: ")
        assert re.match(r"line \d+[,:] ", rest) or rest.startswith(whole_file), rest
    else:
        assert str(description)
