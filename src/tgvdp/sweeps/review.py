"""What the file of a sweep holds, as `tgvdp.formats.review` says it of files that hold trains and lines."""

from collections.abc import Iterator

from tgvdp.formats.review.describe import Description
from tgvdp.formats.review.figures import Figure
from tgvdp.formats.review.plausibility import Review, check_track, check_train
from tgvdp.formats.syntax.reading import listed, shown
from tgvdp.sweeps.spec import Axis, SweepSpec
from tgvdp.units import counted


def describe_spec(spec: SweepSpec, name: str) -> Description:
    """Describe a sweep that has been read: how much it is, of what, and what varies.

    Parameters
    ----------
    spec : SweepSpec
    name : str
        Of the file.
    """
    remarks = (*(remark for part in (*spec.trains, *spec.lines) for remark in part.remarks), *spec.tables.remarks)
    return Description(
        kind="sweep",
        format="spec",
        name=name,
        figures=(
            Figure("scenarios", f"{len(spec)}, {multiplied(spec)}", ""),
            Figure("trains", listed([part.name for part in spec.trains]), ""),
            Figure("lines", listed([part.name for part in spec.lines]), ""),
            *(Figure(" and ".join(axis.names), listed(list(_rows(axis))), "") for axis in spec.axes),
            *(Figure(f"run {field}", str(value), "") for field, value in spec.run.items()),
        ),
        notes=tuple(dict.fromkeys(remarks)),
    )


def multiplied(spec: SweepSpec) -> str:
    """What a sweep multiplies: ``2 trains × 4 sections of 2 lines × 3 wind_kmh``."""
    sections = sum(map(len, spec.sections))
    varied = "".join(f" × {len(axis.rows)} {' and '.join(axis.names)}" for axis in spec.axes)
    counts = (counted(len(spec.trains), "train"), counted(sections, "section"), counted(len(spec.lines), "line"))
    return "{} × {} of {}{}".format(*counts, varied)


def review_spec(spec: SweepSpec) -> list[Review]:
    """Review all trains and lines of a sweep; they stand in files of their own, and so have no line in this one."""
    checked = [
        *(("train", train.name, check_train(train.value)) for train in spec.trains),
        *(("track", line.name, check_track(line.value)) for line in spec.lines),
    ]
    return [Review(kind, name, tuple((check, None) for check in checks)) for kind, name, checks in checked]


def _rows(axis: Axis) -> Iterator[str]:
    for row in axis.rows:
        values = [value if isinstance(value, str) else shown(value) for value in row]
        yield values[0] if len(values) == 1 else f"({', '.join(values)})"
