"""Meshes of Lagrange bodies, of shapes or from files, with the surfaces that a scene uses."""

from collections.abc import Iterable, Iterator

from cea.errors import InputError
from cea.mesh import Mesh
from cea.warned import ResultWarning
from meshes.mesh_file import MeshFile
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene


def used_surfaces(scene: Scene, body: str) -> list[str]:
    """Surfaces of a body that supports, springs, loads and contacts name."""
    spec = scene.bodies[body]
    places = [load.surface for load in scene.loads if load.surface is not None]
    places += [side for contact in scene.contacts.values() for side in (contact.a, contact.b)]
    own = [place.partition(".")[2] for place in places if place.partition(".")[0] == body]
    held = [support.surface for support in spec.supports]
    held += [spring.surface for spring in spec.springs]
    return list(dict.fromkeys([*held, *own]))


def body_mesh(body: str, spec: BodySpec, surfaces: Iterable[str]) -> Mesh:
    """Mesh of a body of Lagrange elements; of a mesh file, with the surfaces that are asked for."""
    if isinstance(spec.geometry, MeshFile):
        try:
            return spec.geometry.mesh(surfaces, spec.placement)
        except InputError as error:
            field = f"bodies.{body}.geometry.{error.field}"
            raise InputError(field, error.value, error.allowed) from None
    from meshes.breaks import breaks_of
    from meshes.shape_mesh import shape_mesh

    fe = spec.mesh.fe
    if fe is None:
        raise InputError(f"bodies.{body}.mesh.fe", None, "needed for 'fe'")
    breaks = None
    if fe.elements is not None:
        breaks = breaks_of(spec.geometry, fe.elements, fe.boundaries)
    return shape_mesh(
        spec.geometry,
        fe.cell,
        fe.geometry_degree or fe.degree,
        breaks=breaks,
        size=fe.size,
        placement=spec.placement,
        edges=fe.edges,
        layers=fe.layers,
    )


def changed_elements(scene: Scene) -> dict[str, str]:
    """What becomes of elements of mesh files that meshes here do not have, with the bodies."""
    files = {n: b.geometry for n, b in scene.bodies.items() if isinstance(b.geometry, MeshFile)}
    parts = {name: file.elements for name, file in files.items()}
    divided = [name for name, part in parts.items() if part.is_divided]
    filled = [name for name, part in parts.items() if part.incomplete and name not in divided]
    told = {}
    if filled:
        told["serendipity"] = (
            f"elements of {', '.join(filled)} get the middles of faces and cells: the same "
            "geometry, displacements of the Lagrange space"
        )
    if divided:
        told["mixed elements"] = (
            f"elements of {', '.join(divided)}, of several kinds, are divided into tetrahedra: "
            "nodes are kept, those on diagonals are put by the elements' own shape functions"
        )
    if left_out := [
        f"{name}: {each}" for name, file in files.items() for each in file.content.told
    ]:
        told["mesh files"] = f"not taken from the file of {'; '.join(left_out)}"
    return told


def nodes_left_out(scene: Scene) -> Iterator[ResultWarning]:
    """Sets of nodes that hold more of a body than the faces that they are used for."""
    for body, spec in scene.bodies.items():
        if isinstance(spec.geometry, MeshFile):
            counts = spec.geometry.nodes_left_out(used_surfaces(scene, body))
            for surface, count in counts.items():
                yield ResultWarning(
                    "nodes-left-out",
                    f"{count} nodes of the set of {body}.{surface} make no face with others of the "
                    "set and are left out: supports, springs, loads and contacts act on faces",
                    {"body": body, "surface": surface, "nodes": count},
                )
