"""Run as a program: an Ansys archive, read by mapdl-archive, as arrays in a file of numpy."""

import re
import sys
from pathlib import Path

_NODES = re.compile(
    rb"(?im)^[ \t]*NBLOCK,.*\n(?:[ \t]*\(.*\n)?(?:[ \t]*\d.*\n)*"
    rb"(?:[ \t]*(?:N,[^\n]*,)?[ \t]*-1.*\n)?"
)
"""Nodes from NBLOCK to the line that ends them."""


def main(archive: str, arrays: str) -> None:
    """Read an archive and write its arrays.

    Parameters
    ----------
    archive
        The archive.
    arrays
        The file (.npz) to write: nodes by number and position, elements one after the other and
        where each ends, types by number, and components of nodes and of elements.
    """
    import numpy as np
    from mapdl_archive import Archive

    read = Archive(archive, parse_vtk=False)
    numbers, nodes = read.nnum, np.asarray(read.nodes)
    blocks = _NODES.findall(Path(archive).read_bytes())
    if len(blocks) > 1:  # of several, the library keeps one
        one, each = f"{arrays}.cdb", []
        for block in blocks:
            Path(one).write_bytes(b"/PREP7\n" + block + b"FINISH\n")
            each.append(Archive(one, parse_vtk=False))
        numbers = np.concatenate([part.nnum for part in each])
        nodes = np.concatenate([part.nodes for part in each])
    components = {
        f"{kind} {name}": numbers
        for kind, of_kind in (("node", read.node_components), ("element", read.element_components))
        for name, numbers in of_kind.items()
    }
    elements = list(read.elem)
    np.savez(
        arrays,
        numbers=numbers,
        points=nodes[:, :3],
        elements=np.concatenate(elements),
        ends=np.cumsum([len(element) for element in elements]),
        types=read.ekey,
        **components,
    )


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except Exception:  # whatever comes up in a broken file, mostly in words of no use
        sys.exit("it is not as CDWRITE writes blocked archives")
