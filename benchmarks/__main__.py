"""``python -m benchmarks [NAME ...] [--quick]`` measures; ``python -m benchmarks summary`` renders the table."""

import argparse
import os
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from benchmarks.timing import ONE_CORE, ROOT, pin

#: Name → module and what it needs. Each module's `run` returns None when that is absent.
BENCHMARKS = {
    "accuracy": ("accuracy", "the folder of reference data beside the project"),
    "ipopt": ("peer_ipopt", "CasADi (the extra `peers`)"),
    "labels": ("peer_boa", "a C compiler"),
    "scaling": ("scaling", ""),
    "startup": ("startup", ""),
    "phases": ("phases", ""),
}

#: Pages of their own beside the folder of the results: module, whose `main` takes the folder, and whether "all" has it.
PAGES = {"formulations": True, "quantum": False}


def main(arguments: list[str] | None = None) -> int:
    os.environ.update(ONE_CORE)  # before anything loads numba or a linear algebra library
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure tgvdp, alone and against peers.")
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"{', '.join((*BENCHMARKS, *PAGES))} or summary; default: all but quantum",
    )
    parser.add_argument("--quick", action="store_true", help="small cases, few repeats: to see that it works")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "benchmarks", help="folder of the results")
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared", help="folder of reference data")
    parser.add_argument("--readme", type=Path, help="with summary: file whose benchmark table is replaced")
    options = parser.parse_args(arguments)
    names = options.names or [*BENCHMARKS, *(name for name, usual in PAGES.items() if usual), "summary"]
    unknown = [name for name in names if name not in (*BENCHMARKS, *PAGES, "summary")]
    if unknown:
        parser.error(f"unknown benchmark {unknown[0]!r}; there are {', '.join((*BENCHMARKS, *PAGES))} and summary")
    core = pin()
    print(f"pinned to core {core}" if core is not None else "this platform cannot pin a process to a core")
    for name in names:
        if name == "summary":
            from benchmarks.summary import summarise

            print(summarise(options.out, options.readme))
        elif name in PAGES:
            import_module(f"benchmarks.{name}").main(options.out.parent / name)
        else:
            _measure(name, options)
    return 0


def _measure(name: str, options: argparse.Namespace) -> None:
    from benchmarks.output import write_report
    from tgvdp.report.plain import markdown_table

    module, need = BENCHMARKS[name]
    run: Callable = import_module(f"benchmarks.{module}").run
    started = time.perf_counter()
    report = run(options.shared, options.quick)
    elapsed_s = time.perf_counter() - started
    if report is None:
        print(f"{name}: skipped, it needs {need}")
        return
    write_report(report, options.out, elapsed_s)
    print(f"\n{report.title} ({elapsed_s:.0f} s)\n\n{markdown_table(report.rows)}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
