"""Is this a train, and is this a line? Figures beside the ranges that they usually lie in; slips of unit stand out."""

from dataclasses import dataclass, replace

from tgvdp.formats.detect import load_to_describe, read_target
from tgvdp.formats.review.figures import Figure, track_figures, train_figures
from tgvdp.formats.review.places import Places
from tgvdp.formats.sources import Source, locate
from tgvdp.model.track import Track
from tgvdp.model.train import Train


@dataclass(frozen=True)
class Review:
    """Checks of one train or line of a file, each with its line there (None where it stands in no line of its own)."""

    kind: str
    name: str
    checks: tuple[tuple[Figure, int | None], ...]

    @property
    def warnings(self) -> int:
        """How many checks are outside their usual range."""
        return sum(not check.ok for check, _ in self.checks)

    @property
    def unusual(self) -> "Review":
        """The same with the checks outside their usual range alone."""
        return replace(self, checks=tuple((check, line) for check, line in self.checks if not check.ok))

    def __str__(self) -> str:
        """Several lines, for the terminal."""
        lines = [f"plausibility of {self.kind} {self.name}: {self.warnings or 'no'} warning{'s'[: self.warnings != 1]}"]
        lines += [
            f"  {'ok     ' if check.ok else 'warning'}  {check_text(check)}{'' if line is None else f', line {line}'}"
            for check, line in self.checks
        ]
        return "\n".join(lines)


def review_file(source: Source, *, line_speed_mps: float | None = None) -> list[Review]:
    """Review all trains and lines of a file, or a name of the catalog.

    Parameters
    ----------
    source : str or path
    line_speed_mps : float, optional
        See `tgvdp.formats.load.load_track`.

    Raises
    ------
    InputError
        When it cannot be read or is wrong.
    """
    target = locate(source)
    document = read_target(target, line_speed_mps)
    scenarios = load_to_describe(source, line_speed_mps=line_speed_mps)
    reviews = []
    for scenario in scenarios:
        part = scenario.name if len(scenarios) > 1 else target.part
        if scenario.train is not None:
            places = Places(document, scenario.format, "train", part)
            checks = check_train(scenario.train)
            located = tuple((check, places.line(check.field)) for check in checks)
            reviews.append(Review("train", scenario.train.name, located))
        if scenario.track is not None:
            places = Places(document, scenario.format, "track", part)
            located = tuple((check, places.line(check.field)) for check in check_track(scenario.track))
            reviews.append(Review("track", scenario.track.name, located))
    return reviews


def check_train(train: Train) -> list[Figure]:
    """Figures of a train that have a usual range."""
    return [figure for figure in train_figures(train) if figure.field]


def check_track(track: Track) -> list[Figure]:
    """Figures of a line that have a usual range."""
    return [figure for figure in track_figures(track) if figure.field]


def check_text(check: Figure) -> str:
    """One line: the figure, its usual range and, where it lies outside, the likeliest slip."""
    usual = f"usual {check.low:.6g} to {check.high:.6g}"
    text = f"{check.name} {check.value:.4g} {check.unit}".rstrip()
    return f"{text} ({usual}{'' if check.ok or not check.hint else f': {check.hint}'})"
