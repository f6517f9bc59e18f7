"""Files as people write them: one plate in every spelling, its frequencies known from elsewhere."""

import numpy as np
import pytest

from scenes import run_modes
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

FREQUENCIES = [2096.2054, 3939.5816, 6647.2061]
"""Of the plate of 4 x 2 x 1 trilinear hexahedra, held at x = 0 (Hz), found without this program."""
X = [[x, y, z] for z in (0, 0.01) for y in (0, 0.015, 0.03) for x in (0, 0.02, 0.04, 0.06, 0.08)]
FIRST = [1, 2, 3, 4, 6, 7, 8, 9]
CELLS = [[n, n + 1, n + 6, n + 5, n + 15, n + 16, n + 21, n + 20] for n in FIRST]
NODES = "".join(f"{i}, {x:.5f}, {y:.5f}, {z:.5f}\n" for i, (x, y, z) in enumerate(X, 1))
ROWS = [f"{i}, " + ", ".join(map(str, row)) + "\n" for i, row in enumerate(CELLS, 1)]
ELEMENTS = "".join(ROWS)
CLAMP = "1, 6, 11, 16, 21, 26\n"
HEAD = f"*NODE\n{NODES}"
BODY = f"{HEAD}*ELEMENT, TYPE=C3D8R, ELSET=PLATE\n{ELEMENTS}"
HELD = f"*NSET, NSET=CLAMP\n{CLAMP}"
PART = f"*PART, NAME=plate\n{BODY}*END PART\n*ASSEMBLY, NAME=all\n*INSTANCE, NAME=Plate-1, PART="
PLACED = "0.5, 0, 0\n0.5, 0, 0, 0.5, 0, 1, 90\n*END INSTANCE\n"
SPARSE = "".join(
    f"{i}, " + ", ".join(f"{c:.5f}" if c else "" for c in x).rstrip(", ") + "\n"
    for i, x in enumerate(X, 1)
)

DECKS = {
    "sets of nodes spelt in two ways": (
        BODY + "*NSET, NSET=Clamp\n1, 6, 11\n*NSET, NSET=CLAMP\n16, 21, 26\n", {}),
    "parts and instances spelt in two ways": (
        f"{PART}PLATE\n{PLACED}*NSET, NSET=CLAMP, INSTANCE=PLATE-1\n{CLAMP}", {"part": "plate-1"}),
    "sets of whole instances": (
        f"{PART}plate, ELSET=EALL, NSET=NALL\n{PLACED}*NSET, NSET=CLAMP, INSTANCE=plate-1\n{CLAMP}",
        {"part": "EALL"}),
    "surfaces before their sets, spelt otherwise": (
        f"*SURFACE, NAME=Clamp, TYPE=ELEMENT\nclamp, S6\n{BODY}*ELSET, ELSET=CLAMP\n1, 5\n", {}),
    "coordinates left out": (BODY.replace(NODES, SPARSE) + HELD, {}),
    "nodes in a file": (BODY.replace(f"*NODE\n{NODES}", "*NODE, INPUT=nodes.txt\n") + HELD, {}),
    "comments in keywords, CRLF and tabs": (
        (f"*NODE,\n** here\n NSET=NALL\n{NODES}*ELEMENT,\n type=C3D8,\n** a body\n elset=PLATE\n"
         + ELEMENTS.replace(", ", ",\t") + HELD).replace("\n", "\r\n"), {}),
    "files in files, by the folder of the file, with backslashes": (
        f"*INCLUDE, INPUT=mesh\\near.inp\n{HELD}", {}),
}  # fmt: skip


def plate(folder, deck, **geometry):
    """A scene of the plate that a deck holds."""
    (folder / "plate.inp").write_bytes(deck.encode())
    (folder / "nodes.txt").write_text(NODES)
    (folder / "mesh").mkdir()
    (folder / "mesh/nodes.inp").write_text(HEAD)
    (folder / "mesh/elements.inp").write_text(f"*ELEMENT, TYPE=C3D8\n{ELEMENTS}")
    (folder / "mesh/near.inp").write_text(
        "*INCLUDE, INPUT=nodes.inp\n*INCLUDE, INPUT=elements.inp\n"
    )
    file = {"shape": "mesh_file", "file": str(folder / "plate.inp"), "unit": "m", **geometry}
    body = {"backend": "fe", "geometry": file, "material": {"E": 2e11, "nu": 0.3, "rho": 7800}}
    body["supports"] = [{"surface": "Clamp" if "NAME=Clamp" in deck else "CLAMP"}]
    analysis = {"kind": "cea", "max_frequency": 12000}
    return {"name": "plate", "bodies": {"plate": body}, "analysis": analysis}


@pytest.mark.parametrize("name", DECKS)
def test_one_plate_in_every_spelling(tmp_path, name):
    deck, geometry = DECKS[name]
    result = run_modes(read_scene(plate(tmp_path, deck, **geometry)))
    np.testing.assert_allclose(result.modes.frequencies, FREQUENCIES, rtol=1e-7)
    assert result.warnings == ()


@pytest.mark.parametrize(
    ("deck", "words"),
    [
        (f"{BODY}{HELD}*ELEMENT, TYPE=MASS, ELSET=LUMP\n900, 30\n*MASS, ELSET=LUMP\n0.5\n", "MASS"),
        (f"{BODY}{HELD}*NSET, NSET=OLD\nGONE\n", "GONE"),
        (f"*INCLUDE, INPUT=mesh/Nodes.inp\n{HELD}", "mesh/Nodes.inp.*case-sensitive"),
        (f"*INCLUDE, INPUT=plate.inp\n{HELD}", "include each other"),
        (f"{PART}plate, LIBRARY=old\n{PLACED}", "LIBRARY=old"),
        (f"{BODY}{HELD}*IMPERFECTION, FILE=modes, STEP=1\n1, 0.1\n", "IMPERFECTION"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path, deck, words):
    with pytest.raises(SceneError, match=words):
        read_scene(plate(tmp_path, deck))


@pytest.mark.parametrize("more", ["2, 30\n", "2, 3, 4, 5\n"])
def test_nodes_of_a_support_that_make_no_face_are_told(tmp_path, more):
    result = run_modes(read_scene(plate(tmp_path, BODY + HELD.rstrip() + ", " + more)))
    np.testing.assert_allclose(result.modes.frequencies, FREQUENCIES, rtol=1e-7)
    (told,) = result.warnings
    assert (told.kind, told.data["nodes"]) == ("nodes-left-out", len(more.split(",")))
    assert told.data["surface"] == "CLAMP"
