"""``tgvdp warm``: compile all that a search may need, before somebody waits for it."""

import time
import warnings

import click

from tgvdp.cli import echo_json
from tgvdp.cli.screen import Screen
from tgvdp.errors import InputError
from tgvdp.second_process import SecondProcess

SCHEMA = "tgvdp.warm/1"
_EXAMPLES = """
\b
Examples:
  tgvdp warm
  TGVDP_CACHE_DIR=/opt/tgvdp tgvdp warm          in an image: the folder may be read-only after that
"""


@click.command("warm", epilog=_EXAMPLES)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(as_json: bool, quiet: bool) -> None:
    """Compile everything that tgvdp search may need, so that no later search waits for it.

    It is kept in $TGVDP_CACHE_DIR, or else in your cache folder, until tgvdp, Python, numba or numpy change.
    """
    started = time.perf_counter()
    with Screen(quiet=quiet or as_json) as screen, SecondProcess() as second, warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # what cannot be kept is compiled in vain
        try:
            from tgvdp.api import warm

            if not warm.is_compiled():
                raise InputError("warm: NUMBA_DISABLE_JIT is set, so nothing is ever compiled")
            screen.progress("looking for what is compiled")
            with screen.compiling():
                # The checks come last: they call a kernel that the tour begins with, and find it compiled by then. The
                # tour ends with one of theirs.
                parts = [second.promise(f"tgvdp.api.warm:{task}") for task in ("ascents", "kinks", "checks")]
                done = warm.tour("front")
                parts += [second.promise("tgvdp.api.warm:tour", name) for name in ("clean", "exact", "best-first")]
                done += warm.tour("map") + warm.margins()
                with screen.waiting():
                    done += [one for part in parts for one in part()]
        except RuntimeWarning as warning:
            raise InputError(f"warm: {warning}") from None
    elapsed_s = time.perf_counter() - started
    if as_json:
        kernels = [one._asdict() for one in done]
        content = {"schema": SCHEMA, "folder": str(warm.key_folder()), "compiled": kernels, "elapsed_s": elapsed_s}
        echo_json(content)
    elif not quiet:
        for one in done:
            click.echo(f"{one.elapsed_s:6.1f} s  {one.kernel}")
        what = f"compiled {len(done)} kernels in {elapsed_s:.1f} s" if done else "everything is compiled already"
        click.echo(f"{what}, in {warm.key_folder()}")
