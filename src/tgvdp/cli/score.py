"""``tgvdp score``: a recorded run against the front."""

import time
from collections.abc import Mapping
from typing import Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_file, complete_folder, complete_source
from tgvdp.cli.folder import OutFolder
from tgvdp.cli.notes import remarked
from tgvdp.cli.numbers import number
from tgvdp.cli.places import place
from tgvdp.cli.screen import Screen, duration
from tgvdp.cli.search_case import read_case
from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN
from tgvdp.constants import CONVENTION_NAMES

#: A saving below which nothing is said of where it lies, %.
_LITTLE_PCT = 0.5
#: A saving, or its opposite, that no record tells, %.
_NOTHING_PCT = 0.05
#: A time below which nobody arrives earlier, s: records are no finer.
_LITTLE_S = 0.1
_EXAMPLES = """
\b
Examples:
  tgvdp score run.csv --train tgv --track lgv-100km
  tgvdp score gps.csv --train stock.yaml --track line.json --from 12000 --to 43500 --smooth 5
  tgvdp score day.csv --train tgv --track lgv-100km --section 2 --energy pantograph --json
\b
The columns of RUN.csv are two or three of position, speed and time, with units in the head: position_m,speed_kmh
or time [s];speed [km/h]. Decimal commas need ; or tabs between the columns.
"""


@click.command("score", epilog=_EXAMPLES)
@click.argument("run", metavar="RUN.csv", shell_complete=complete_file)
@click.option(
    "--train", metavar="FILE|NAME", default=DEFAULT_TRAIN, show_default=True, shell_complete=complete_source,
    help="Train: a file, or a name of the catalog.",
)  # fmt: skip
@click.option(
    "--track", metavar="FILE|NAME", default=DEFAULT_TRACK, show_default=True, shell_complete=complete_source,
    help="Line: a file, or a name of the catalog.",
)  # fmt: skip
@click.option(
    "--from", "from_m", metavar="M|STOP", type=place(at_least=0.0), help="The record is shifted to start here."
)
@click.option("--to", "to_m", metavar="M|STOP", type=place(), help="... and stretched to end here.")
@click.option("--section", metavar="N", type=click.IntRange(min=1), help="Which section between two stands.")
@click.option(
    "--smooth", "window_s", metavar="S", type=number("s", at_least=0.0),
    help="Speeds are means over so many seconds, slopes kept out.  [default: as recorded; 10 where no speed is]",
)  # fmt: skip
@click.option(
    "--energy", metavar="MODEL", default="wheel", show_default=True, shell_complete=complete_source,
    help="What is compared: wheel, pantograph, or a map of the power drawn.",
)  # fmt: skip
@click.option(
    "--convention", type=click.Choice(CONVENTION_NAMES), help="Whose reading of the line.  [default: ttobench]"
)
@click.option(
    "--out",
    metavar="DIR",
    default="score",
    show_default=True,
    shell_complete=complete_folder,
    help="Folder of score.json and score.png.",
)
@click.option("--force", is_flag=True, help="Write into a folder that holds files of others.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(
    run: str,
    train: str,
    track: str,
    from_m: float | str | None,
    to_m: float | str | None,
    section: int | None,
    window_s: float | None,
    energy: str,
    convention: str | None,
    out: str,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Hold a recorded run against the front: what did it cost, and what would the best run of that time have cost?

    Efforts are not recorded. They are estimated by the train's model: inertia and resistance; negative effort is
    braking. Where the speed is noisy the estimate is too high: --smooth takes noise away, and rounds corners of the
    speed. Where no speeds are recorded those at the ends are told by the positions near them. The optimum has the same
    ends, speeds at them, and running time.
    """
    from tgvdp.formats import load_run

    folder = OutFolder(out, "score.json", force=force)
    options: dict[str, Any] = {"energy": energy} if convention is None else {"energy": energy, "convention": convention}
    with Screen(quiet=quiet) as screen:
        record, case = load_run(run), read_case(train, track, None)
        for text in remarked(case.remarks):
            screen.note(text)
        screen.progress("searching")
        from tgvdp.api import score_run  # brings numba: neither --help nor an error in the input waits for it
        from tgvdp.report import make_provenance
        from tgvdp.report.pictures import encode
        from tgvdp.report.plain import to_json
        from tgvdp.report.provenance import write_ledger
        from tgvdp.report.scores import plot_score, score_object

        started_s = time.perf_counter()
        ends_m = case.placed({"from_m": from_m, "to_m": to_m})
        score = score_run(
            record,
            case.train,
            case.track,
            start_m=ends_m["from_m"],
            end_m=ends_m["to_m"],
            section=section,
            window_s=window_s,
            **options,
        )
        content = score_object(score)
        screen.progress("drawing and writing")
        asked = {**ends_m, "section": section, "smooth_s": window_s, **score.result.options}
        provenance = make_provenance(asked, {"record": run, **case.inputs}, time.perf_counter() - started_s)
        content["provenance"] = provenance
        picture = encode(plot_score(score), provenance)
        files = write_ledger(out, {"score.json": to_json(content), "score.png": picture}, provenance)
    folder.drop_earlier(files)
    if as_json:
        echo_json(content)
    elif not quiet:
        click.echo(_table(content))
        click.echo(f"in {out}: {', '.join(file.name for file in files)}")
    if "warning" in content and not quiet:
        click.echo(f"tgvdp: warning: {content['warning']}", err=True)


def _table(content: Mapping[str, Any]) -> str:
    lines = [
        f"{content['record']}: {content['train']} on {content['track']},"
        f" {content['origin_m']:.6g} m to {content['destination_m']:.6g} m",
        f"{'':>9}  {'time':>9}  {'margin':>8}  {'energy':>14}  traction  cruising  coasting   braking",
    ]
    for name in ("recorded", "optimum"):
        run = content[name]
        shares = "  ".join(f"{value:6.0f} %" for value in run["distance_pct"].values())
        figures = f"{duration(run['time_s']):>9}  {run['margin_pct']:6.2f} %  {run['energy_kwh']:10.5g} kWh"
        lines.append(f"{name:>9}  {figures}  {shares}")
    reference = (
        "the optimum of that time" if content["recorded"]["margin_pct"] >= 0.0 else "the fastest run of the model"
    )
    if abs(content["saving_pct"]) < _NOTHING_PCT:
        return "\n".join([*lines, f"{reference} takes as much, to {_NOTHING_PCT:g} %"])
    parts = [
        f"{abs(content[field]):.4g} kWh {'less' if content[field] >= 0.0 else 'more'} {what}"
        for field, what in (("saving_in_brakes_kwh", "braked away"), ("saving_in_resistance_kwh", "against resistance"))
    ]
    saving = f"{abs(content['saving_kwh']):.4g} kWh"
    does = f"saves {saving}" if content["saving_kwh"] >= 0.0 else f"takes {saving} more"
    lines.append(f"{reference} {does}, {abs(content['saving_pct']):.1f} %; at the wheel {' and '.join(parts)}")
    if content["earlier_s"] is not None and content["earlier_s"] >= _LITTLE_S:
        lines.append(f"with the recorded energy it arrives {content['earlier_s']:.4g} s earlier")
    if content["saving_pct"] >= _LITTLE_PCT:  # below, differences of parts say more of the record than of the driver
        worst = max(content["parts"], key=lambda part: part["recorded_kwh"] - part["optimum_kwh"])
        lines.append(
            f"most of it between {worst['from_m']:.0f} m and {worst['to_m']:.0f} m:"
            f" {worst['recorded_kwh']:.4g} kWh against {worst['optimum_kwh']:.4g} kWh"
        )
    return "\n".join(lines)
