"""An annulus of one patch that closes on itself, or of four, with the same functions."""

import numpy as np
from pydantic import TypeAdapter

from meshes.patches import Patches

LINE = [0.0, 0.0, 1.0, 1.0]
ARC = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
ARCS = [0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0]
AROUND = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]])


def annulus(inner, outer, *, quarters=False, gap=0.0):
    """Its geometry as a scene has it; the last of the quarters is moved by a gap (m)."""
    net = AROUND[:, None] * np.array([inner, outer])[:, None]
    weights = np.array([1.0 if i % 2 == 0 else 0.5**0.5 for i in range(9)])
    spans = [slice(2 * q, 2 * q + 3) for q in range(4)] if quarters else [slice(9)]
    patches = [
        {
            "degrees": [2, 1],
            "knots": [ARC if quarters else ARCS, LINE],
            "control_points": net[span].tolist(),
            "weights": np.column_stack([weights[span]] * 2).tolist(),
        }
        for span in spans
    ]
    patches[-1]["control_points"][-1][-1][1] -= gap
    faces = {
        name: [[patch, 1, side] for patch in range(len(patches))]
        for side, name in enumerate(("inner", "outer"))
    }
    return {"shape": "patches", "patches": patches, "faces": faces}


as_shape = TypeAdapter(Patches).validate_python
"""The same as a shape."""
