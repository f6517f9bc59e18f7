"""Run time of a scene, estimated before work starts.

    t = t_0 + a F + b N + (c + d m) L + e L^(3/2)

F counts entries of the element matrices of Lagrange bodies, N entries of the stiffness of NURBS
bodies, L entries of the factors of the stiffness, m modes. The terms are set-up, assembly, Krylov
vectors with what a factorisation reads and writes, and its floating point operations, which grow as
L^(3/2) in nested dissection of a body in space.

The five numbers are fits to the 1,800 stored runs of comparisons/accuracy/results, up to 12,000
unknowns on one core of an x86_64 machine: 98 % of them took 0.7 to 3.8 times the estimate, half of
them 0.9 to 1.3 times. What quadratic problems and steady sliding add is not fitted but counted.
"""

from math import prod

from meshes.mesh_file import MeshFile
from scenes.checking.memory import MemoryEstimate
from scenes.spec.body import BodySpec
from scenes.spec.node_grids import elements_along, node_grids
from scenes.spec.reading import Scene

_START, _ELEMENT_ENTRY, _NURBS_ENTRY = 0.03, 1.7e-7, 2.0e-7
_FACTOR_ENTRY, _FACTOR_ENTRY_A_MODE, _OPERATION = 3.1e-8, 1.3e-9, 3.5e-11
_QUADRATIC = 8.0
"""Work in the Krylov space of a damped or rotating system relative to that of a linear problem: of
four times the columns, of displacements and velocities."""
_SHIFTS = 3.0
"""Shifts of a damped or rotating system, where a linear problem has one."""
_NEWTON = 10.0
"""Factorisations on the way to steady sliding: its steps of load times those of Newton's method."""


def estimated_seconds(scene: Scene, memory: MemoryEstimate) -> float:
    """Seconds that a scene takes on one core, without pictures.

    Parameters
    ----------
    scene
        The scene.
    memory
        What it takes of memory (:func:`scenes.checking.memory.estimated_memory`).
    """
    entries, modes = memory.factor_entries, memory.modes
    static = scene.analysis.kind == "static"
    factorisation = _FACTOR_ENTRY * entries + _OPERATION * entries**1.5
    seconds = _START + sum(map(_assembly, scene.bodies.values())) + factorisation
    if not static:
        krylov = _FACTOR_ENTRY_A_MODE * modes * entries
        if scene.damped or scene.rotates:
            seconds += _SHIFTS * factorisation + _QUADRATIC * krylov
        else:
            seconds += krylov
    if scene.slides_steadily:
        seconds += _NEWTON * factorisation
    return seconds


def _assembly(body: BodySpec) -> float:
    """Seconds that the matrices of a body take."""
    dim, fe = len(body.geometry.directions), body.mesh.fe
    if body.backend == "fe" and fe is not None:
        elements = prod(elements_along(body, fe, 1.0))
        return _ELEMENT_ENTRY * dim**2 * elements * (fe.degree + 1.0) ** (2 * dim)
    if isinstance(body.geometry, MeshFile):
        shape_functions = (body.fe_degree or 1) + 1.0
        return _ELEMENT_ENTRY * dim**2 * body.geometry.num_cells * shape_functions ** (2 * dim)
    couplings = sum(prod(grid.counts) * prod(grid.couplings) for grid in node_grids(body, 1.0))
    return _NURBS_ENTRY * dim**2 * couplings
