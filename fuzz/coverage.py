"""Bytes that lead readers into new branches: ``python -m fuzz.coverage [-max_total_time=60 ...]`` (extra ``fuzz``).

atheris instruments the readers and keeps what reaches code that nothing reached before. A file is read, or refused in
one line; anything else is a crash, which libFuzzer writes down. Options are libFuzzer's.
"""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["tgvdp.formats", "tgvdp.model"]):
    from fuzz.inputs import originals
    from tgvdp.errors import InputError
    from tgvdp.formats.detect import load_bytes

#: What a file may be called; the first byte of what is tried chooses one.
_SUFFIXES = (".json", ".toml", ".yaml", ".xml", ".csv", ".xlsx")
#: Larger files take libFuzzer too long, B.
_LARGEST_B = 20_000


def read(data: bytes) -> None:
    """Read one file; an error that is none of the input's, or of several lines, is a crash."""
    suffix = _SUFFIXES[data[0] % len(_SUFFIXES)] if data else _SUFFIXES[0]
    try:
        load_bytes(f"file{suffix}", data[1:])
    except InputError as error:
        if "\n" in str(error):
            raise AssertionError(f"not one line: {error}") from error


def main() -> None:
    """Try files that are made from small ones of every format, until libFuzzer has enough."""
    with tempfile.TemporaryDirectory(prefix="tgvdp-corpus-") as corpus:
        for original in originals():
            suffix = Path(original.name).suffix
            content = original.write(original.tree).encode()
            if suffix in _SUFFIXES and len(content) <= _LARGEST_B:
                (Path(corpus) / original.name).write_bytes(bytes([_SUFFIXES.index(suffix)]) + content)
        atheris.Setup([sys.argv[0], corpus, f"-max_len={_LARGEST_B}", *sys.argv[1:]], read)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
