"""XML from strangers is refused fast and in one line, or parsed without surprises."""

import sys
import time

import pytest

from tests.helpers.railml_line_case import LINE_2
from tgvdp.errors import InputError, MissingExtraError
from tgvdp.formats import describe_file, load_track
from tgvdp.formats.syntax.reading import LARGEST_BYTES
from tgvdp.formats.syntax.xml import DEEPEST, MOST_ATTRIBUTES, MOST_ELEMENTS, parse_xml

pytest.importorskip("lxml")

BOMB = '<!DOCTYPE railml [<!ENTITY a "{}">{}]>'.format(
    50 * "x", "".join(f'<!ENTITY {chr(98 + i)} "{10 * f"&{chr(97 + i)};"}">' for i in range(9))
)


def refused(path, data):
    """Line of the refusal of some bytes, without the path; it comes within a second."""
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    started = time.perf_counter()
    with pytest.raises(InputError) as caught:
        describe_file(path)
    assert time.perf_counter() - started < 1.0
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert line.isprintable()
    return line.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (BOMB + '<railml version="2.3">&j;</railml>', "line 1: declares a document type or an entity"),
        (f'\n{BOMB}<railml version="&j;"/>', "line 2: declares a document type or an entity"),
        ('<!DOCTYPE railml SYSTEM "http://localhost/x.dtd"><railml version="2.3"/>', "line 1: declares a document"),
        ('<railml version="2.3"><!DOCTYPE a></railml>', "line 1: declares a document type"),
        ("<!DOCTYPE railml>".encode("utf-16"), "line 1: declares a document type"),
        ('<railml version="2.3">&external;</railml>', "line 1: is not well-formed XML: Entity 'external' not defined"),
        ('<railml version="2.3" version="2.4"/>', "line 1: is not well-formed XML: Attribute version redefined"),
        ("<railml>", "line 1: is not well-formed XML: "),
        ("<", "line 1: is not well-formed XML: "),
        ("<railml", "line 1: is not well-formed XML: "),
        ("<html/>", "holds XML, but neither railML nor SFERA to be run: its root is 'html'"),
        ("<railml/>", "line 1, railml@version: missing attribute"),
        (
            '<railml version="1.0"/>',
            "line 1, railml@version: must be one of 2.0, 2.1, 2.2, 2.3, 2.4, 2.5, 3.1, 3.2, 3.3, got '1.0'",
        ),
        ('<railml version="2.33"/>', "line 1, railml@version: must be one of"),
        ('<railml version="2.3"/>', "holds no track and no train"),
        (b"<?xml version='1.0' encoding='utf-7'?><railml/>", "line 1: unknown encoding 'utf-7'"),
        (b"<railml name='\xff'/>", "is not utf-8 text (byte 14)"),
        (b"\xff\xfe<\0r\0x", "is not utf-16 text"),
        (b"<railml>\0</railml>", "line 1: is not well-formed XML: "),
        ("<a>" * 100_000, "line 1: is not well-formed XML: Excessive depth"),
        ("<a>" * (DEEPEST + 1) + "</a>" * (DEEPEST + 1), f"is nested too deeply: more than {DEEPEST} elements"),
        ("<railml>" + "<a/>" * (MOST_ELEMENTS + 1) + "</railml>", f"holds more than {MOST_ELEMENTS} elements"),
        ("<railml>" + "<a></a>" * (MOST_ELEMENTS + 1) + "</railml>", f"holds more than {MOST_ELEMENTS} elements"),
        (
            "<railml " + " ".join(f'a{i}=""' for i in range(MOST_ATTRIBUTES // 3)) + "/>",
            "line 1",
        ),
        ("<railml " + 'a="" ' * (MOST_ATTRIBUTES + 1) + "/>", f"holds more than {MOST_ATTRIBUTES} attributes"),
        (b"<railml>" + (LARGEST_BYTES - 8) * b" " + b"x", "is larger than 20 MB"),
        (b"<railml>" + (LARGEST_BYTES - 20) * b"x" + b"</railml>", "line "),
    ],
    ids=lambda value: str(value)[:40],
)
def test_refusals(tmp_path, data, message):
    assert refused(tmp_path / "input.xml", data).startswith(message)


@pytest.mark.parametrize("number", ["NaN", "INF", "-inf", "1e999", "-1e999", "9" * 500, "1_0", "0x10", "١", "", " "])
def test_wild_numbers_are_refused_with_their_place(tmp_path, number):
    text = LINE_2.replace('pos="2100" dir="up"', f'pos="{number}" dir="up"')
    place = "line 24, railml/infrastructure/tracks/track/trackElements/gradientChanges/gradientChange[2]@pos: must be "
    assert refused(tmp_path / "input.xml", text).startswith(place)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1", "windows-1252"])
def test_encodings(tmp_path, encoding):
    declared = encoding.removesuffix("-sig")
    text = LINE_2.replace('"UTF-8"', f'"{declared}"').replace('name="Main"', 'name="Zürich–Wil"')
    if encoding == "iso-8859-1":
        text = text.replace("–", "-")
    (tmp_path / "line.xml").write_bytes(text.encode(encoding))
    assert load_track(tmp_path / "line.xml#t1:up").name.startswith("Zürich")


def test_lxml_is_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "lxml.etree", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'tgvdp\[formats\]'$") as caught:
        parse_xml(tmp_path / "line.xml", b"<railml/>")
    assert str(caught.value).count("\n") == 0


def test_what_was_not_read_is_counted_by_name(tmp_path):
    root = parse_xml(tmp_path / "a.xml", b"<r><a b='1' c='2' id='x'><d/><d/><e f='3'/></a><a b='4'/></r>")
    first, second = root.children("a")
    first.text("b")
    first.child("e")
    assert root.unused() == ["a@b", "a@c", "d (2)", "e@f"]
    second.dismiss()
    assert root.unused() == ["a@c", "d (2)", "e@f"]


def test_elements_of_other_namespaces_do_not_count_as_the_format(tmp_path):
    root = parse_xml(tmp_path / "a.xml", b"<r xmlns='urn:a' xmlns:o='urn:o'><o:a/><a/></r>")
    assert len(root.children("a")) == 1
    assert root.unused() == ["a"]


def test_repeated_elements_are_refused_where_one_is_meant(tmp_path):
    root = parse_xml(tmp_path / "a.xml", b"<r>\n<a/>\n<a/></r>")
    with pytest.raises(InputError, match=r"line 3, r/a\[2\]: is given twice, first in line 2"):
        root.child("a")
