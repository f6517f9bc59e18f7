"""Scenes of matrices: files, parameters, and the sums of matrices that give M, C and K.

    lambda^2 M(t) + lambda C(t) + K(t),    M, C, K = sum_j c_j(t) A_j

The A_j are read from files; the c_j are numbers or arithmetic expressions in the parameters t.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import ConfigDict

from cea.expressions import RESERVED, Formula
from scenes.spec.consistency import LARGEST, SMALLEST, check_no_steady_state, check_scene_name
from scenes.spec.plain import OF_MATRICES, changed, checked, scene_file, set_fields, tables_of
from scenes.spec.problems import Faults, refuse
from scenes.spec.reading import ComplexEigenvalueAnalysis

Role = Literal["mass", "damping", "stiffness"]
ROLES: tuple[Role, ...] = ("mass", "damping", "stiffness")
"""Matrices of the pencil, each a weighted sum of matrices from files."""

PARAMETERS = "parameters"
"""Section whose entries are the parameters of the pencil, by their paths."""

Number = float | str
"""A number, or an arithmetic expression as text."""


@dataclass(frozen=True)
class MatrixScene:
    """A quadratic eigenvalue problem whose matrices are sums of matrices from files.

    Parameters
    ----------
    name
        Name of the scene.
    files
        File of each matrix by the matrix's name in the sums; ``file.mat:variable`` for a file of
        several matrices.
    mass, stiffness, damping
        Coefficient of each matrix in M (kg), K (N/m) and C (N s/m, damping and gyroscopic terms):
        a number, or an arithmetic expression in the parameters and pi
        (:class:`cea.expressions.Formula`).
    analysis
        Window of the modes to compute.
    parameters
        Values by name: numbers, or arithmetic expressions in pi.
    symmetric
        For each file that holds one triangle, by matrix name: true to mirror the triangle of a
        symmetric matrix, false to use the triangle as it is. Other files are read as they are.
    data
        Folder of the files; paths are relative to it.
    description
        Free text.
    """

    name: str
    files: dict[str, str]
    mass: dict[str, Number]
    stiffness: dict[str, Number]
    analysis: ComplexEigenvalueAnalysis
    damping: dict[str, Number] = field(default_factory=dict)
    parameters: dict[str, Number] = field(default_factory=dict)
    symmetric: dict[str, bool] | None = None
    data: str = ""
    description: str = ""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False
    )

    @property
    def backends(self) -> str:
        """Label shown instead of backends."""
        return "matrices"

    @property
    def window(self) -> ComplexEigenvalueAnalysis:
        """Window of the modes to compute."""
        return self.analysis

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters by their paths in the scene, ``parameters.NAME``."""
        paths = {f"{PARAMETERS}.{name}": value for name, value in self.parameters.items()}
        return {path: _formula(value, {}, path).at({}) for path, value in paths.items()}

    def sum(self, role: Role) -> dict[str, Formula]:
        """Return the coefficient of each matrix in one of the sums."""
        names = {name: f"{PARAMETERS}.{name}" for name in self.parameters}
        found: Mapping[str, float | str] = getattr(self, role)
        return {m: _formula(value, names, f"{role}.{m}") for m, value in found.items()}

    def file(self, matrix: str) -> tuple[Path, str | None]:
        """Return the file of a matrix, and the variable in it."""
        name, variable = split_name(self.files[matrix])
        return Path(self.data) / name, variable

    def change(self, field: str | Mapping[str, Any], value: Any = None) -> "MatrixScene":
        """Return the scene with fields changed, as :meth:`scenes.spec.reading.Scene.change`."""
        return read_matrix_scene(changed(self, field, value))


def load_matrices(
    scene: str | Path, overrides: Iterable[str] = (), data: str | Path | None = None
) -> MatrixScene:
    """Read a scene of matrices.

    Parameters
    ----------
    scene, overrides
        As :func:`scenes.spec.reading.load_scene` takes them.
    data
        Folder of the files; by default the scene's ``data``, relative to the scene file.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    tables, folder = tables_of(scene), scene_file(scene).parent
    if "bodies" in tables and "files" not in tables:
        refuse("scene", str(scene), "a scene of matrices; one of bodies is read by load_scene")
    comes_with_the_project = folder == OF_MATRICES
    if not comes_with_the_project and isinstance(tables.get("data", ""), str):
        tables["data"] = str(folder / tables.get("data", ""))
    if data is not None:
        tables["data"] = str(data)
    set_fields(tables, overrides)
    read = read_matrix_scene(tables)
    if comes_with_the_project and not read.data:
        files = ", ".join(read.files.values())
        refuse("data", None, f"the folder of {files}, which do not come with it")
    return read


def read_matrix_scene(data: Mapping[str, Any]) -> MatrixScene:
    """Check a scene given as nested dictionaries and return a :class:`MatrixScene`.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    scene, faults = checked(MatrixScene, data), Faults()
    analysis = scene.analysis
    check_scene_name(faults, scene.name)
    top, allowed = analysis.max_frequency, f"{SMALLEST:g} to {LARGEST:g} (Hz)"
    faults.require(SMALLEST <= top <= LARGEST, "analysis.max_frequency", top, allowed)
    check_no_steady_state(faults, analysis, "left out: matrices have no contacts")
    names = [f"files.{name}" for name in scene.files]
    names += [f"{PARAMETERS}.{name}" for name in scene.parameters]
    for place in names:
        name = place.partition(".")[2]
        fits = name.isidentifier() and name.isascii() and name not in RESERVED
        allowed = f"a name of letters, digits and _, none of {', '.join(sorted(RESERVED))}"
        faults.require(fits, place, name, allowed)
    before = len(faults)
    faults.of(lambda: scene.values)
    if len(faults) == before:
        _sum_checks(faults, scene)
    faults.refuse()
    return scene


def _sum_checks(faults: Faults, scene: MatrixScene) -> None:
    there = f"one of the files: {', '.join(scene.files) or 'there are none'}"
    sums = {role: getattr(scene, role) for role in ROLES}
    for role, coefficients in sums.items():
        given = role == "damping" or bool(coefficients)
        faults.require(given, role, {}, "at least one matrix with its coefficient")
        for matrix in coefficients:
            faults.require(matrix in scene.files, f"{role}.{matrix}", matrix, there)
        faults.of(lambda role=role: [c.at(scene.values) for c in scene.sum(role).values()])
    for name in scene.symmetric or ():
        faults.require(name in scene.files, f"symmetric.{name}", name, there)
    for name, file in scene.files.items():
        named = any(name in coefficients for coefficients in sums.values())
        faults.require(named, f"files.{name}", file, "named in a sum, or left out")


def _formula(value: float | str, names: Mapping[str, str], place: str) -> Formula:
    return Formula(value if isinstance(value, str) else repr(value), names, place)


def split_name(text: str) -> tuple[str, str | None]:
    """Split ``file.mat:variable`` into file and variable; the variable is None if there is none."""
    name, colon, variable = text.rpartition(":")
    if colon and name.endswith(".mat") and variable.isidentifier():
        return name, variable
    return text, None
