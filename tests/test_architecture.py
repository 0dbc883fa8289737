"""Data flows one way: files → model → line → physics → runs → methods → certificate → report. Imports point back."""

import ast
import statistics
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tgvdp._jit.cache import KERNEL_FREE

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "tgvdp"

#: Leaves that every room may use.
LEAVES = {"errors", "memory", "progress", "units", "constants", "cores", "second_process", "start", "__version__"}

#: Room → the rooms it may import besides itself and the leaves. Edges (cli, api) stand last.
MAY_IMPORT = {
    "errors": set(),
    "units": set(),
    "constants": set(),
    "memory": set(),
    "progress": set(),
    "cores": set(),
    "second_process": set(),
    "start": set(),
    "pareto": set(),
    "_jit": set(),
    "model": set(),
    "options": {"model"},
    "instances": set(),
    "formats": {"model", "options"},
    "line": {"model", "_jit"},
    "physics": {"model", "_jit"},
    "runs": {"model", "line", "physics", "_jit"},
    "methods": {"model", "line", "physics", "runs", "_jit"},
    "certificate": {"model", "line", "physics", "runs", "methods", "_jit"},
    "margins": {"model", "line", "physics", "runs", "methods"},
    "journeys": {"model", "physics", "runs", "methods", "certificate", "pareto"},
    "referee": {"model", "physics", "_jit"},
    "formulations": {"model", "formats"},  # formats: instances are files
    "solvers": {"model", "formulations", "_jit"},
    "report": {"model", "runs"},
    "sweeps": {"model", "options", "formats", "runs", "pareto", "report", "api"},
    "trials": {"model", "formulations", "instances", "solvers", "report", "api"},
    "api": {
        "model",
        "options",
        "formats",
        "line",
        "runs",
        "methods",
        "certificate",
        "margins",
        "journeys",
        "referee",
        "pareto",
        "report",
        "_jit",
    },
    "explorer": {"model", "options", "formats", "runs", "report", "api"},
    "verification": {
        *("model", "formats", "physics", "runs", "methods", "referee", "formulations", "instances", "solvers"),
        *("report", "api"),
    },
    "cli": {
        *("model", "options", "formats", "report", "api", "formulations", "instances", "solvers", "trials", ""),
        *("explorer", "sweeps", "verification"),
    },
    "__main__": {"cli"},
    "": {"model", "formats", "runs", "referee", "pareto", "api", "sweeps"},  # the package itself: public names
}

#: Room within `formulations` → the others that it may import, for types or not.
FORMULATIONS_MAY_IMPORT = {
    "problem": set(),
    "qubo": {"problem"},
    "program": {"problem"},
    "circuit": {"problem", "qubo"},
}

#: What the referee may use of physics: a judge shares no way of making runs with those whom it judges.
REFEREE_MAY_USE = {"tgvdp.physics.energy", "tgvdp.physics.forces"}

#: Third-party package → the only places that may import it. Extras are never imported at module level.
ONLY_IN = {
    "numba": ("_jit",),
    "llvmlite": ("_jit",),
    "matplotlib": ("report",),
    "networkx": ("methods/grid/networkx_view.py", "formulations/qubo/couplers.py"),
    "click": ("cli",),
    "starlette": ("explorer/server",),
    "uvicorn": ("explorer/server",),
}
#: Extras with a room of their own, which only a command that needs them imports: there they may stand at the top.
AT_HOME = {"starlette", "uvicorn"}
CORE = {"numpy", "numba", "llvmlite", "networkx", "matplotlib", "click", "msgspec", "tomli_w"}
QUANTUM = {"dimod", "dwave", "qiskit", "qiskit_aer", "docplex", "neal"}
SILENT = {"line", "physics", "runs", "methods", "certificate", "journeys", "referee"}  # no files, no printing
FILE_CALLS = {"open", "print", "input"}
FILE_MODULES = {"pathlib", "os", "io", "shutil", "tempfile", "json", "csv", "logging"}


class Import(NamedTuple):
    path: Path
    line: int
    room: str
    target: str
    at_module_level: bool
    for_types_only: bool

    def __str__(self):
        return f"{self.path.relative_to(PACKAGE.parent)}:{self.line}: {self.room or 'tgvdp'} imports {self.target}"


def room_of(path):
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py") if first != "__init__.py" else ""


def is_type_checking(node):
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def imports_of(path, text=None):
    room = room_of(path)

    def walk(node, at_module_level, for_types_only):
        for child in ast.iter_child_nodes(node):
            inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            if isinstance(child, ast.Import):
                targets = [alias.name for alias in child.names]
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"{path}:{child.lineno}: imports are absolute"
                # `from tgvdp import api` imports the room api.
                inner = child.module == "tgvdp"
                targets = [f"tgvdp.{alias.name}" for alias in child.names] if inner else [child.module]
            else:
                yield from walk(child, at_module_level and not inside, for_types_only or is_type_checking(child))
                continue
            for target in targets:
                yield Import(path, child.lineno, room, target, at_module_level, for_types_only)

    yield from walk(ast.parse(path.read_text() if text is None else text), True, False)


SOURCES = sorted(PACKAGE.rglob("*.py"))
IMPORTS = [one for path in SOURCES for one in imports_of(path)]


def target_room(one):
    """Room of an import within the package; a public name of the package counts as the package itself."""
    parts = one.target.split(".")
    if parts[0] != "tgvdp":
        return None
    return parts[1] if len(parts) > 1 and parts[1] in {*MAY_IMPORT, *LEAVES} else ""


def direction_faults(imports):
    for one in imports:
        target = target_room(one)
        # What a type checker alone reads does not run: report names the result that api hands to it.
        if target is None or target == one.room or one.for_types_only:
            continue
        if target not in LEAVES | MAY_IMPORT[one.room]:
            yield str(one)


def third_party_faults(imports):
    for one in imports:
        top = one.target.partition(".")[0]
        place = one.path.relative_to(PACKAGE).as_posix()
        if top in ONLY_IN and not place.startswith(ONLY_IN[top]):
            yield f"{one}, which only {' and '.join(ONLY_IN[top])} may"
        if top in QUANTUM and one.room != "solvers":
            yield f"{one}, which only solvers may"
        known = top in CORE | AT_HOME or top == "tgvdp" or top in sys.stdlib_module_names
        if not known and one.at_module_level and not one.for_types_only:
            yield f"{one}, an extra, at module level"


def noise_faults(path, tree):
    if room_of(path) not in SILENT:
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FILE_CALLS:
            yield f"{path.name}:{node.lineno}: calls {node.func.id}"


def test_every_room_has_its_rule():
    assert {room_of(path) for path in SOURCES} <= set(MAY_IMPORT)


def test_imports_point_back_along_the_flow():
    assert list(direction_faults(IMPORTS)) == []


def referee_faults(imports):
    for one in imports:
        if one.room == "referee" and target_room(one) == "physics" and one.target not in REFEREE_MAY_USE:
            yield f"{one}, which makes runs"


def test_the_referee_shares_nothing_with_those_it_judges():
    assert list(referee_faults(IMPORTS)) == []


def formulation_faults(imports):
    for one in imports:
        if one.room != "formulations" or target_room(one) != "formulations":
            continue
        inner, target = one.path.relative_to(PACKAGE).parts[1], one.target.split(".")[2]
        if inner in FORMULATIONS_MAY_IMPORT and target not in {inner, *FORMULATIONS_MAY_IMPORT[inner]}:
            yield str(one)


def test_a_problem_knows_none_of_its_forms_and_forms_flow_into_circuits():
    rooms = {path.parent.name for path in SOURCES if path.parent.parent == PACKAGE / "formulations"}
    assert rooms == set(FORMULATIONS_MAY_IMPORT)
    assert list(formulation_faults(IMPORTS)) == []


def module_of(path):
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


def served_to_kernels():
    """All modules that a module with kernels imports, directly or not."""
    modules = {module_of(path): path for path in SOURCES}
    targets = {name: set() for name in modules}
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                inner = {f"{node.module}.{alias.name}" for alias in node.names} & set(modules)
                targets[module_of(path)] |= inner | ({node.module} & set(modules))
    found, ahead = set(), [name for name in modules if "tgvdp._jit" in targets[name]]
    while ahead:
        name = ahead.pop()
        if name not in found:
            found.add(name)
            ahead += targets[name]
    return [modules[name].relative_to(PACKAGE).as_posix() for name in found]


def test_rooms_outside_the_key_of_the_kernel_cache_hold_no_kernel_and_serve_none():
    served = served_to_kernels()
    assert len(served) > 40
    assert [place for place in served if place.startswith(tuple(f"{room}/" for room in KERNEL_FREE))] == []


def test_third_party_packages_stay_in_their_rooms():
    assert list(third_party_faults(IMPORTS)) == []


def test_rooms_that_compute_neither_print_nor_touch_files():
    calls = [fault for path in SOURCES for fault in noise_faults(path, ast.parse(path.read_text()))]
    modules = [
        str(one) for one in IMPORTS if one.room in SILENT and one.target.partition(".")[0] in FILE_MODULES | {"click"}
    ]
    assert calls + modules == []


@pytest.mark.parametrize(
    ("room", "text"),
    [
        ("methods/a.py", "from tgvdp.formulations.qubo.qubo import build"),
        ("formulations/a.py", "import tgvdp.methods.grid.exact"),
        ("formulations/problem/a.py", "if TYPE_CHECKING:\n    from tgvdp.formulations.qubo.qubo import Qubo"),
        ("formulations/qubo/a.py", "from tgvdp.formulations.program.files import lp_text"),
        ("formulations/program/a.py", "def f():\n    from tgvdp.formulations.circuit.qaoa import Gate"),
        ("instances/a.py", "from tgvdp.formulations.problem.instances import read_instance"),
        ("model/a.py", "from tgvdp.formats import load_train"),
        ("physics/a.py", "def f():\n    from tgvdp.line.cells import cells_of"),
        ("referee/a.py", "from tgvdp.line.resolved import resolve"),
        ("referee/a.py", "from tgvdp.physics.arc import arc"),
        ("referee/a.py", "def f():\n    from tgvdp.runs.profile import profile_of"),
        ("certificate/a.py", "from tgvdp import api"),
        ("line/a.py", "import numba"),
        ("methods/a.py", "import matplotlib.pyplot as plt"),
        ("methods/grid/a.py", "import networkx"),
        ("solvers/a.py", "import dimod"),
        ("trials.py", "def f():\n    import qiskit"),
        ("runs/a.py", "import casadi"),
        ("explorer/compute/a.py", "def f():\n    import starlette"),
        ("report/a.py", "from tgvdp.explorer.assets import assets"),
    ],
)
def test_rules_catch_a_breach(room, text):
    imports = list(imports_of(PACKAGE / room, text))
    checks = (direction_faults, third_party_faults, referee_faults, formulation_faults)
    assert [fault for check in checks for fault in check(imports)]


def test_rules_allow_extras_inside_functions():
    imports = list(imports_of(PACKAGE / "solvers" / "a.py", "def f():\n    import dimod"))
    assert not [*direction_faults(imports), *third_party_faults(imports)]


HEAVY = ("numpy", "numba", "matplotlib", "networkx", "msgspec")


def loaded_by(code):
    """Heavy packages that a fresh interpreter has loaded after running some code."""
    check = f"import sys\n{code}\nprint(*[name for name in {HEAVY} if name in sys.modules], sep=' ', file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=60, check=True)
    return done.stderr.split()


def test_import_loads_nothing_heavy():
    assert loaded_by("import tgvdp") == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["--version"],
        ["search", "--help"],
        ["catalog", "--help"],
        ["solve", "--help"],
        ["bench", "--help"],
        ["sweep", "--help"],
    ],
)
def test_help_loads_nothing_heavy(arguments):
    assert loaded_by(f"from tgvdp.cli import main\nmain({arguments})") == []


@pytest.mark.parametrize("arguments", [["-c", "import tgvdp"], ["-m", "tgvdp", "--help"]])
def test_start_up_is_measured(arguments):
    """Prints, and asserts nothing about, durations: they belong to the machine (figures: 50 ms and 150 ms)."""
    code = (
        "import subprocess, sys, time\n"
        "for _ in range(5):\n"
        "    t = time.perf_counter(); subprocess.run([sys.executable, *sys.argv[1:]], stdout=subprocess.DEVNULL)\n"
        "    print(time.perf_counter() - t)"
    )
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    print(f"{' '.join(arguments)}: median {1e3 * statistics.median(map(float, done.stdout.split())):.0f} ms")


TESTS = Path(__file__).resolve().parent


def test_tests_mirror_the_rooms():
    folders = {path.name for path in TESTS.iterdir() if any(path.glob("**/test_*.py"))}
    assert folders <= set(MAY_IMPORT) | {"benchmarks", "fuzz"}  # which are no part of the package, but tested


def test_no_test_imports_a_test():
    found = [
        f"{path.relative_to(TESTS)}:{node.lineno}"
        for path in TESTS.rglob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and str(node.module).rpartition(".")[2].startswith("test_")
    ]
    assert found == []
