"""Files whose nodes, elements or sets stand in several places."""

import re

import gmsh
import numpy as np
import pytest
from dolfinx import io
from dolfinx import mesh as dolfinx_mesh
from mesh_writers import file_of, made, two_boxes, write
from mpi4py import MPI

from meshes.mesh_file import MeshFile
from meshes.unstructured import gmsh_session


@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
def test_a_volume_in_two_groups_is_there_once(tmp_path, version):
    """Files of version 2.2 list elements once for each group."""
    file = tmp_path / "a.msh"
    with gmsh_session():
        for x in (0, 1):
            gmsh.model.occ.addBox(x, 0, 0, 1, 1, 1)
        gmsh.model.occ.fragment([(3, 1)], [(3, 2)])
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [1, 2], name="whole")
        gmsh.model.addPhysicalGroup(3, [2], name="half")
        low = [tag for _, tag in gmsh.model.getEntities(2)
               if gmsh.model.occ.getCenterOfMass(2, tag)[0] < 0.1]  # fmt: skip
        gmsh.model.addPhysicalGroup(2, low, name="low")
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(file))
    whole, half = (MeshFile(str(file), "m", part=part) for part in ("whole", "half"))
    assert (whole.extent[0], half.extent[0]) == ((0.0, 2.0), (1.0, 2.0))
    assert (
        MeshFile(str(file), "m").elements.num_cells
        == whole.elements.num_cells
        == 2 * half.elements.num_cells
    )
    mesh = whole.mesh(["low"])
    assert (mesh.points[mesh.surfaces["low"]][..., 0] == 0).all()


def test_nodes_in_several_blocks_of_ansys(tmp_path):
    file = file_of(tmp_path, "a.cdb")
    data = write(two_boxes("hexahedron", 2), file, lacking=True)["right"]
    whole = made(data).mesh(["x_min"])
    lines = file.read_text().splitlines()
    start, end = (next(i for i, line in enumerate(lines) if line.startswith(word)) for word in
                  ("NBLOCK", "N,R5.3"))  # fmt: skip
    nodes, n = lines[start + 2 : end], end - start - 2
    blocks = []
    for part in (nodes[: n // 3], nodes[n // 3 :]):
        blocks += [f"NBLOCK,6,SOLID,{n},{len(part)}", lines[start + 1], *part, lines[end]]
    file.write_text("\n".join([*lines[:start], *blocks, *lines[end + 1 :]]) + "\n")
    read = made(data).mesh(["x_min"])
    np.testing.assert_array_equal(read.points[read.cells], whole.points[whole.cells])
    np.testing.assert_array_equal(read.surfaces["x_min"], whole.surfaces["x_min"])


CELLS = {"tetrahedron": dolfinx_mesh.CellType.tetrahedron}
CELLS["hexahedron"] = dolfinx_mesh.CellType.hexahedron


@pytest.mark.parametrize("cell", CELLS)
def test_a_mesh_and_its_tags_as_dolfinx_writes_them(tmp_path, cell):
    file = file_of(tmp_path, "a.xdmf")
    ends = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]])
    box = dolfinx_mesh.create_box(MPI.COMM_SELF, ends, [4, 2, 2], CELLS[cell])
    n = box.topology.index_map(3).size_local
    middles = dolfinx_mesh.compute_midpoints(box, 3, np.arange(n, dtype=np.int32))
    box.topology.create_connectivity(2, 3)
    low = dolfinx_mesh.locate_entities_boundary(box, 2, lambda x: np.isclose(x[0], 0))
    cells = dolfinx_mesh.meshtags(
        box, 3, np.arange(n, dtype=np.int32), 1 + (middles[:, 0] > 1).astype(np.int32)
    )
    facets = dolfinx_mesh.meshtags(box, 2, np.sort(low), np.full(len(low), 7, dtype=np.int32))
    cells.name, facets.name = "cells", "facets"
    with io.XDMFFile(MPI.COMM_SELF, str(file), "w") as written:
        written.write_mesh(box)
        written.write_meshtags(cells, box.geometry)
        written.write_meshtags(facets, box.geometry)
    faces = {"low": "facets 7"}
    whole = MeshFile(str(file), "m", faces=faces)
    half = MeshFile(str(file), "m", part="cells 1", faces=faces)
    assert whole.elements.num_cells == 2 * half.elements.num_cells == n
    assert half.extent == ((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
    mesh = half.mesh(["low"])
    on = mesh.points[mesh.surfaces["low"]]
    assert (on[..., 0] == 0).all()
    assert len(on) == len(low)


def test_several_kinds_of_cells_in_one_topology(tmp_path):
    """A cube of two wedges beside a hexahedron, in numbers written out."""
    points = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1, 2)]
    cells = [9, 0, 1, 4, 3, 6, 7, 10, 9, 8, 1, 2, 5, 7, 8, 11, 8, 1, 5, 4, 7, 11, 10]
    text = " ".join(" ".join(map(str, x)) for x in points)
    (tmp_path / "a.xdmf").write_text(
        '<Xdmf Version="3.0"><Domain><Grid><Geometry GeometryType="XYZ">'
        f'<DataItem Dimensions="12 3" Format="XML">{text}</DataItem></Geometry>'
        '<Topology TopologyType="Mixed" NumberOfElements="3">'
        f'<DataItem Dimensions="{len(cells)}" NumberType="Int" Format="XML">'
        f"{' '.join(map(str, cells))}</DataItem></Topology></Grid></Domain></Xdmf>"
    )
    body = MeshFile(str(tmp_path / "a.xdmf"), "m")
    mesh = body.mesh([])
    corners = mesh.points[mesh.cells]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6
    assert volume == pytest.approx(2.0)
    assert re.search("wedge", ",".join(b.cell for b in body.content.blocks))
