"""The rooms: imports point one way, between packages, folders and files, and nothing is hidden."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ARROWS = {
    "cea": (),
    "meshes": ("cea.arrays", "cea.errors", "cea.files", "cea.mesh"),
    "exact_cea": ("cea.errors", "cea.files"),
    "fe_cea": ("cea",),
    "iga_cea": ("cea",),
    "scenes": ("cea", "fe_cea", "iga_cea", "meshes"),
    "comparisons": ("cea", "fe_cea", "iga_cea", "meshes", "exact_cea", "scenes"),
}
"""What each package may import beside itself: of packages without PETSc light modules alone."""
APPLICATIONS = sorted(
    folder.name
    for folder in (ROOT / "comparisons").iterdir()
    if (folder / "__init__.py").is_file() and folder.name not in ("study", "cli")
)
BESIDE_US = "comparisons.bench.assembly"
"""Programs that assembly is compared with and that come with this one."""
DRAWING = ("scenes.results.pictures", "scenes.export.paraview")
"""Modules that need pyvista; all others import them in the functions that draw."""
LIBRARIES = {
    "petsc4py slepc4py mpi4py dolfinx_solver": ("cea.petsc",),
    "gmsh": ("meshes",),
    "matplotlib": ("comparisons",),
    "flint": ("exact_cea",),
    "dolfinx ufl basix ffcx": ("fe_cea", BESIDE_US),
    "typer rich": ("comparisons.cli",),
    "pyvista vtk vtkmodules": DRAWING,
}
"""Where some libraries may be imported, and nowhere else."""
MODULES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
    for package in ARROWS
    for file in sorted((ROOT / package).rglob("*.py"))
}


def imported_names(module, *, at_once=False):
    """Every name that a module imports, in functions too unless only those ``at_once``.

    ``from a import b`` gives ``a.b``: b may be a module. Relative imports are refused.
    """
    names = set()

    def visit(node):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{module}: relative import"
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            later = isinstance(child, ast.FunctionDef | ast.Lambda)
            typing = isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)
            if not (at_once and (later or typing)):
                visit(child)

    visit(ast.parse(MODULES[module].read_text(encoding="utf-8")))
    return names


def own_modules(names):
    """Modules of the project among imported names: the longest beginning that is a module."""
    found = set()
    for name in names:
        while name and name not in MODULES:
            name = name.rpartition(".")[0]
        found.add(name)
    return found - {""}


NAMES = {module: imported_names(module) for module in MODULES}
WITHIN = {module: own_modules(NAMES[module]) - {module} for module in MODULES}


def between_folders():
    """The other folders that files of each folder import from; an ``__init__`` is its folder."""
    folder = {
        module: module if MODULES[module].name == "__init__.py" else module.rpartition(".")[0]
        for module in MODULES
    }
    folders = {each: set() for each in folder.values()}
    for module, imported in WITHIN.items():
        folders[folder[module]] |= {folder[name] for name in imported} - {folder[module]}
    return folders


def lies_in(module, places):
    """Whether a module is one of some modules, or lies in one of some packages."""
    return any(f"{module}.".startswith(f"{place}.") for place in places)


def beyond(home, allowed):
    """What modules of a place import of the project that lies in none of some places."""
    wrong = {
        module: {name for name in imported if not lies_in(name, [home, *allowed])}
        for module, imported in WITHIN.items()
        if lies_in(module, [home])
    }
    return {module: others for module, others in wrong.items() if others}


@pytest.mark.parametrize("graph", [WITHIN, between_folders()], ids=["files", "folders"])
def test_no_circle_between_files_or_folders(graph):
    """The root of cea imports none of its folders."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))
    assert sum(map(len, WITHIN.values())) > 500
    assert between_folders()["cea"] == set()


def test_arrows_between_packages_and_none_between_applications():
    allowed = dict(ARROWS)
    for room in (*APPLICATIONS, "study"):
        allowed[f"comparisons.{room}"] = ["comparisons.study", *(set(ARROWS) - {"comparisons"})]
    for place, others in allowed.items():
        assert beyond(place, others) == {}


def test_the_command_line_and_programs_beside_this_one_are_imported_by_none():
    for hidden, home in (("comparisons.cli", "comparisons.cli"), (BESIDE_US, "comparisons.bench")):
        importers = {m for m, others in WITHIN.items() if any(lies_in(o, [hidden]) for o in others)}
        assert {module for module in importers if not lies_in(module, [home])} == set()


def test_libraries_stay_in_their_rooms():
    for names, places in LIBRARIES.items():
        for module, imported in NAMES.items():
            found = set(names.split()) & {name.partition(".")[0] for name in imported}
            assert not found or lies_in(module, places), module


def test_pyvista_is_brought_in_where_pictures_are_drawn():
    for module in set(MODULES) - set(DRAWING):
        at_once = own_modules(imported_names(module, at_once=True))
        assert not at_once & set(DRAWING), module
