"""The rooms: imports point one way, between packages, folders and files, and nothing is hidden."""

from pathlib import Path

import pytest
from rooms import (
    circles,
    folder_of,
    imports_between_folders,
    imports_of_others,
    imports_within,
    modules_in,
)

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
MODULES = modules_in(ROOT, ARROWS)
WITHIN = imports_within(MODULES)
APPLICATIONS = sorted(
    folder.name
    for folder in (ROOT / "comparisons").iterdir()
    if (folder / "__init__.py").is_file() and folder.name not in ("study", "cli")
)
BESIDE_US = "comparisons.bench.assembly"
"""Programs that assembly is compared with and that come with this one."""
DRAWING = (
    *("scenes.pictures.drawing", "scenes.pictures.grids", "scenes.pictures.scene"),
    "scenes.export.paraview",
)
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


def lies_in(module, places):
    """Whether a module is one of some modules, or lies in one of some packages."""
    return any(f"{module}.".startswith(f"{place}.") for place in places)


def beyond(module, places):
    """What a module imports of the project that lies in none of some places."""
    return {other for other in WITHIN[module] if not lies_in(other, places)}


def test_every_package_is_looked_at():
    assert {module.partition(".")[0] for module in MODULES} == set(ARROWS)
    assert set(APPLICATIONS) >= {"formulations", "accuracy", "paper"}
    assert sum(map(len, WITHIN.values())) > 500


def test_no_circle_between_files_or_folders():
    assert circles(WITHIN) == circles(imports_between_folders(MODULES)) == []


def test_root_of_cea_imports_none_of_its_folders():
    assert imports_between_folders(MODULES)["cea"] == set()


@pytest.mark.parametrize("package", ARROWS)
def test_arrows_between_packages(package):
    own = [module for module in MODULES if lies_in(module, [package])]
    wrong = {module: beyond(module, [package, *ARROWS[package]]) for module in own}
    assert {module: others for module, others in wrong.items() if others} == {}


@pytest.mark.parametrize("room", [*APPLICATIONS, "study"])
def test_no_application_is_imported_by_another_or_by_the_engine(room):
    allowed = [f"comparisons.{room}", "comparisons.study", *(set(ARROWS) - {"comparisons"})]
    own = [module for module in MODULES if lies_in(module, allowed[:1])]
    wrong = {module: beyond(module, allowed) for module in own}
    assert {module: others for module, others in wrong.items() if others} == {}


@pytest.mark.parametrize("hidden", ["comparisons.cli", BESIDE_US])
def test_the_command_line_and_programs_beside_this_one_are_imported_by_none(hidden):
    importers = {m for m, others in WITHIN.items() if any(lies_in(o, [hidden]) for o in others)}
    home = folder_of(hidden, MODULES) if hidden == BESIDE_US else hidden
    assert {folder_of(module, MODULES) for module in importers} <= {home}


@pytest.mark.parametrize("names", LIBRARIES)
def test_libraries_stay_in_their_rooms(names):
    libraries, places = set(names.split()), LIBRARIES[names]
    wrong = {
        module: imported & libraries
        for module, imported in imports_of_others(MODULES).items()
        if imported & libraries and not lies_in(module, places)
    }
    assert wrong == {}


def test_pyvista_is_brought_in_where_pictures_are_drawn():
    at_once = imports_within(MODULES, at_once=True)
    wrong = {m: i & set(DRAWING) for m, i in at_once.items() if m not in DRAWING}
    assert {module: drawing for module, drawing in wrong.items() if drawing} == {}


@pytest.fixture
def planted(tmp_path):
    """Writes an invented tree of packages, and gives its modules."""

    def plant(sources):
        for name, source in sources.items():
            file = tmp_path.joinpath(*name.split(".")).with_suffix(".py")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(source)
            for folder in file.relative_to(tmp_path).parents:
                (tmp_path / folder / "__init__.py").touch()
        return modules_in(tmp_path, {name.partition(".")[0] for name in sources})

    return plant


@pytest.mark.parametrize(
    "back",
    [
        "import hall.a",
        "from hall import a",
        "from hall.a import thing",
        "from . import a",
        "from .a import thing",
        "def later():\n    from hall.a import thing",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from hall.a import thing",
        "try:\n    import hall.a\nexcept ImportError:\n    pass",
    ],
)
def test_a_planted_circle_of_files_is_found(planted, back):
    modules = planted({"hall.a": "from hall.b import x", "hall.b": "import hall.c", "hall.c": back})
    assert {*circles(imports_within(modules))} == {"hall.a", "hall.b", "hall.c"}
    assert circles(imports_between_folders(modules)) == []


LEFT_AND_RIGHT = {
    "hall.left.a": "from hall.right.b import x",
    "hall.left.d": "",
    "hall.right.b": "",
    "hall.right.c": "from hall.left.d import y",
}
WITH_A_FOLDER = {
    "hall.a": "from hall.sub import b",
    "hall.d": "",
    "hall.sub.b": "",
    "hall.sub.c": "import hall.d",
}


@pytest.mark.parametrize(
    ("sources", "folders"),
    [
        (LEFT_AND_RIGHT, {"hall.left", "hall.right"}),
        (WITH_A_FOLDER, {"hall", "hall.sub"}),
        ({"hall.a": "from hall.b import x", "hall.b": "", "house.c": "import hall.a"}, set()),
    ],
)
def test_a_planted_circle_of_folders_is_found(planted, sources, folders):
    modules = planted(sources)
    assert circles(imports_within(modules)) == []
    assert {*circles(imports_between_folders(modules))} == folders


def test_imports_at_once_leave_out_functions_and_types(planted):
    source = (
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    import hall.b\n"
        "class K:\n    import hall.c\n    def f(self):\n        import hall.d\nimport numpy\n"
    )
    modules = planted({"hall.a": source, "hall.b": "", "hall.c": "", "hall.d": ""})
    assert imports_within(modules)["hall.a"] == {"hall.b", "hall.c", "hall.d"}
    assert imports_within(modules, at_once=True)["hall.a"] == {"hall.c"}
    assert imports_of_others(modules)["hall.a"] == {"typing", "hall", "numpy"}
