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
PACKAGES = ("cea", "fe_cea", "iga_cea", "exact_cea", "meshes", "scenes", "comparisons")
MODULES = modules_in(ROOT, PACKAGES)

ARROWS = {
    "cea": set(),
    "meshes": {"cea"},
    "exact_cea": {"cea"},
    "fe_cea": {"cea"},
    "iga_cea": {"cea"},
    "scenes": {"cea", "fe_cea", "iga_cea", "meshes"},
    "comparisons": {"cea", "fe_cea", "iga_cea", "meshes", "exact_cea", "scenes"},
}
"""What each package may import beside itself."""

LIGHT = {
    "exact_cea": {"cea.errors", "cea.files"},
    "meshes": {"cea.arrays", "cea.errors", "cea.files", "cea.mesh"},
}
"""Modules of ``cea`` that packages without PETSc may import."""

APPLICATIONS = sorted(
    folder.name
    for folder in (ROOT / "comparisons").iterdir()
    if (folder / "__init__.py").is_file() and folder.name not in ("study", "cli")
)
SOLVERS = {"petsc4py", "slepc4py", "mpi4py", "dolfinx_solver"}
BESIDE_US = {"comparisons.bench.assembly"}
"""Programs that assembly is compared with and that come with this one."""
DRAWING = {
    *("scenes.pictures.drawing", "scenes.pictures.grids", "scenes.pictures.scene"),
    "scenes.export.paraview",
}
"""Modules that need pyvista; all others import them in the functions that draw."""


def package_of(module):
    return module.partition(".")[0]


def offending(allowed, libraries):
    """Modules that import one of some libraries, but for those allowed."""
    return {
        module: sorted(imported & set(libraries))
        for module, imported in imports_of_others(MODULES).items()
        if imported & set(libraries) and not allowed(module)
    }


def test_every_package_is_looked_at():
    assert {package_of(module) for module in MODULES} == set(PACKAGES)
    assert set(APPLICATIONS) >= {"formulations", "accuracy", "paper"}
    assert sum(map(len, imports_within(MODULES).values())) > 500


def test_no_circle_between_files():
    assert circles(imports_within(MODULES)) == []


def test_no_circle_between_folders():
    assert circles(imports_between_folders(MODULES)) == []


def test_root_of_cea_imports_none_of_its_folders():
    assert imports_between_folders(MODULES)["cea"] == set()


@pytest.mark.parametrize("package", PACKAGES)
def test_arrows_between_packages(package):
    wrong = {
        module: sorted(others)
        for module, imported in imports_within(MODULES).items()
        if package_of(module) == package
        and (others := {i for i in imported if package_of(i) not in {package, *ARROWS[package]}})
    }
    assert wrong == {}


@pytest.mark.parametrize("package", LIGHT)
def test_packages_without_petsc_import_light_modules_alone(package):
    wrong = {
        module: sorted(heavy)
        for module, imported in imports_within(MODULES).items()
        if package_of(module) == package
        and (heavy := {i for i in imported if package_of(i) == "cea"} - LIGHT[package])
    }
    assert wrong == {}


@pytest.mark.parametrize("room", [*APPLICATIONS, "study"])
def test_no_application_is_imported_by_another_or_by_the_engine(room):
    prefix = f"comparisons.{room}"
    wrong = {
        module: sorted(others)
        for module, imported in imports_within(MODULES).items()
        if f"{module}.".startswith(f"{prefix}.")
        and (
            others := {
                i
                for i in imported
                if i.startswith("comparisons.")
                and not f"{i}.".startswith((f"{prefix}.", "comparisons.study."))
            }
        )
    }
    assert wrong == {}


def test_the_command_line_is_imported_by_none():
    graph = imports_within(MODULES)
    importers = {m for m, imported in graph.items() if any(".cli" in i for i in imported)}
    assert {folder_of(m, MODULES) for m in importers} == {"comparisons.cli"}


def test_one_module_brings_in_petsc():
    assert offending(lambda module: module == "cea.petsc", SOLVERS) == {}


def test_gmsh_stays_in_meshes():
    assert offending(lambda module: package_of(module) == "meshes", {"gmsh"}) == {}


def test_matplotlib_stays_in_comparisons():
    assert offending(lambda module: package_of(module) == "comparisons", {"matplotlib"}) == {}


def test_flint_stays_in_exact_cea():
    assert offending(lambda module: package_of(module) == "exact_cea", {"flint"}) == {}


def test_dolfinx_stays_in_fe_cea():
    dolfinx = {"dolfinx", "ufl", "basix", "ffcx"}
    assert offending(lambda m: package_of(m) == "fe_cea" or m in BESIDE_US, dolfinx) == {}


def test_programs_beside_this_one_are_used_by_nothing_else():
    graph = imports_within(MODULES)
    assert {folder_of(m, MODULES) for m in graph if graph[m] & BESIDE_US} <= {
        folder_of(module, MODULES) for module in BESIDE_US
    }


def test_typer_stays_in_the_command_line():
    inside = folder_of("comparisons.cli.app", MODULES)
    assert offending(lambda m: folder_of(m, MODULES) == inside, {"typer", "rich"}) == {}


def test_pyvista_is_brought_in_where_pictures_are_drawn():
    assert offending(DRAWING.__contains__, {"pyvista", "vtk", "vtkmodules"}) == {}
    wrong = {
        module: sorted(imported & DRAWING)
        for module, imported in imports_within(MODULES, at_once=True).items()
        if module not in DRAWING and imported & DRAWING
    }
    assert wrong == {}


@pytest.fixture
def planted(tmp_path):
    """Writes an invented tree of packages, and gives its modules."""

    def plant(**sources):
        for name, source in sources.items():
            file = tmp_path.joinpath(*name.split("__")).with_suffix(".py")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(source)
            for folder in file.relative_to(tmp_path).parents:
                (tmp_path / folder / "__init__.py").touch()
        return modules_in(tmp_path, {name.partition("__")[0] for name in sources})

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
    modules = planted(hall__a="from hall.b import x", hall__b="import hall.c", hall__c=back)
    assert {*circles(imports_within(modules))} == {"hall.a", "hall.b", "hall.c"}
    assert circles(imports_between_folders(modules)) == []


def test_a_planted_circle_of_folders_is_found(planted):
    modules = planted(
        hall__left__a="from hall.right.b import x",
        hall__right__b="",
        hall__right__c="from hall.left.d import y",
        hall__left__d="",
    )
    assert circles(imports_within(modules)) == []
    assert {*circles(imports_between_folders(modules))} == {"hall.left", "hall.right"}


def test_a_folder_and_its_subfolder_can_make_a_circle(planted):
    modules = planted(
        hall__a="from hall.sub import b", hall__sub__b="", hall__sub__c="import hall.d", hall__d=""
    )
    assert {*circles(imports_between_folders(modules))} == {"hall", "hall.sub"}


def test_a_tree_without_circles_has_none(planted):
    modules = planted(
        hall__a="from hall.b import x\nimport numpy", hall__b="", house__c="import hall.a"
    )
    assert imports_within(modules)["house.c"] == {"hall.a"}
    assert imports_of_others(modules)["hall.a"] == {"hall", "numpy"}
    assert circles(imports_within(modules)) == circles(imports_between_folders(modules)) == []


def test_imports_at_once_leave_out_functions_and_types(planted):
    source = (
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    import hall.b\n"
        "class K:\n    import hall.c\n    def f(self):\n        import hall.d\n"
    )
    modules = planted(hall__a=source, hall__b="", hall__c="", hall__d="")
    assert imports_within(modules)["hall.a"] == {"hall.b", "hall.c", "hall.d"}
    assert imports_within(modules, at_once=True)["hall.a"] == {"hall.c"}
