"""A small made-up comparison with the keys of a real one, and a reader of the page made of it."""

import json
from html.parser import HTMLParser

import numpy as np

from cea.timing import STAGES

EXACT = -1000.0


def timings(scale):
    seconds = {stage: scale * (i + 1) for i, stage in enumerate(STAGES)}
    return {"timings": seconds, "seconds": sum(seconds.values())}


def common(scene, backend, points, scale, skipped):
    status = {"inside": points - 1, "edge": 1, "missed": 0}
    return timings(scale) | {
        "scene": scene | {"bodies": {"disc": {"backend": backend, "mesh": {backend: {}}}}},
        "dofs": {"free": 1000 * points, "bodies": {"disc": 1000 * points}},
        "skipped": skipped,
        "contacts": {"c": {"points": points, "status": status}},
        "backend": backend,
        "points": points,
    }


def patch_run(backend, method, label, P, oscillation, expected):
    along = [EXACT, EXACT + oscillation, None]
    side = {"min": -1.0, "max": 1.0, "arc": [0.0, 4.5, 9.0], "sigma_n_along": along}
    sides = {"a": side | {"oscillation": oscillation / 2}, "b": side | {"oscillation": oscillation}}
    scene = {"name": "patch_test", "description": "Pressure\npasses.", "analysis": {"kind": "s"}}
    return common(scene, backend, 25, 0.01, {"mass": "static analysis"}) | {
        "method": method,
        "formulation": label,
        "P": P,
        "stresses": {"interface": sides},
        "oscillation": oscillation,
        "expected": expected,
    }


def pad_run(backend, method, label, modes, scale):
    eigenvalues = [
        {"re": re, "im": 2 * np.pi * f, "residual": 1e-12 * (i + 1), "condition": 1.5 + i}
        for i, (f, re) in enumerate(modes)
    ]
    scene = {"name": "disc_pad", "analysis": {"kind": "cea", "max_frequency": 15000.0}}
    skipped = {"newton": "known stiffness"} | ({"gmsh": "none"} if backend == "iga" else {})
    return common(scene, backend, 375, scale, skipped) | {
        "method": method,
        "formulation": label,
        "eigenvalues": eigenvalues,
        "unstable": [
            {"mode": i, "frequency": f, "growth": re}
            for i, (f, re) in enumerate(modes, start=1)
            if re > 10
        ],
        "window": {
            "found": 44,
            "discs": 3,
            "complete": False,
            "max_growth": 17567.25,
            "evidence": f"evidence of {backend} {method}",
        },
    }


def disc_run(line, backend, mesh, scale, errors):
    scene = {"name": "disc", "analysis": {"kind": "cea", "max_frequency": 9000.0}}
    run = common(scene, backend, 10, scale, {"search": "no contacts"}) | {
        "contacts": {},
        "line": line,
        "mesh": mesh,
        "frequencies": [1000.0 * (1 + error) for error in errors],
        "worst_error": max(errors),
        "median_error": float(np.median(errors)),
    }
    run["scene"]["bodies"]["disc"]["mesh"][backend] = {"degree": (4, 4, 3)}
    return run


def both(frequency, growth):
    pair = {"frequency": frequency, "growth": growth, "modal_assurance": 0.99871}
    for key in ("frequency", "growth"):
        pair[f"{key}_difference"] = pair[key][0] / pair[key][1] - 1
    return pair


def small_comparison():
    """A small comparison with the keys of a real one."""
    nothing = {"pairs": [], "only_first": [], "only_second": []}
    modes = [(1234.5, 0.0), (6246.92, 363.88), (6246.92, -363.88)]
    near_end = [(1230.0, 0.0), (6240.74, 364.04), (6240.74, -364.04), (14990.0, 84.25)]
    reference = disc_run("reference", "iga", "9 x 64 x 2", 3.0, [0.0] * 3)
    gpts = both([6246.92, 6240.74], [363.88, 364.04])
    return {
        "command": "compare",
        "versions": {"python": "3.12.0"},
        "commit": "0123456789abcdef",
        "warnings": [],
        "machine": {"cpus": 2},
        "seconds": 12.5,
        "patch_test": {
            "exact_sigma_n": EXACT,
            "runs": [
                patch_run("fe", "gpts", "GPTS 15 x 15", 1e6, 38.7, None),
                patch_run("fe", "gpts", "GPTS 15 x 15", 1e14, 1.3e-4, None),
                patch_run("iga", "greville", "Greville", 1e6, 3556.3, 3233.0),
                patch_run("iga", "gpts", "GPTS 15 x 15", 1e6, 0.446, 0.446),
            ],
        },
        "disc_alone": {
            "modes": 3,
            "reference": reference,
            "runs": [
                disc_run("hexahedra", "fe", "3 x 24 x 1", 0.1, [1e-2, 3e-2, 2e-2]),
                disc_run("hexahedra", "fe", "5 x 40 x 1", 0.2, [1e-3, 3e-3, 2e-3]),
                disc_run("NURBS", "iga", "3 x 24 x 1", 0.05, [1e-4, 3e-4, 2e-4]),
            ],
            "backend_differences": [
                {
                    "fe": "5 x 40 x 1",
                    "iga": "3 x 24 x 1",
                    "worst": 2.7e-3,
                    "median": 1.8e-3,
                    "fe_seconds": 0.2,
                    "iga_seconds": 0.05,
                }
            ],
        },
        "disc_pad": {
            "runs": [
                pad_run("fe", "gpts", "GPTS 5 x 5", modes, 1.0),
                pad_run("iga", "greville", "Greville", near_end, 0.5),
                pad_run("iga", "gpts", "GPTS 5 x 5", near_end[:3], 0.5),
            ],
            "agreement": {
                "collocation": {
                    "pairs": [gpts],
                    "only_first": [],
                    "only_second": [{"frequency": 14990.0, "growth": 84.25}],
                },
                "grid": nothing,
                "gpts": nothing | {"pairs": [gpts]},
            },
        },
        "time_saved": {
            "scene": "disc_pad, mu = 0",
            "skipped": {},
            "lean": timings(0.1)["timings"],
            "full": timings(0.2)["timings"],
            "lean_seconds": timings(0.1)["seconds"],
            "full_seconds": timings(0.2)["seconds"],
            "pairs": 4,
            "ratio": {"median": 0.5, "least": 0.45, "largest": 0.55},
            "noise": 0.1,
        },
    }


class Page(HTMLParser):
    """Cells of the tables by id, addresses, tags, data and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.addresses, self.tags, self.text = {}, [], set(), ""
        self.data, self._script = {}, None
        self._rows, self._in_cell = [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Begin a table, row or cell."""
        attributes = dict(attributes)
        self.tags.add(tag)
        self.addresses += [attributes[k] for k in ("src", "href", "srcset") if k in attributes]
        if tag == "script":
            self._script = attributes
        elif tag == "table":
            self._rows = self.tables.setdefault(attributes["id"], [])
        elif tag == "tr":
            self._rows.append([])
        elif tag in ("td", "th"):
            self._rows[-1].append("")
            self._in_cell = True

    def handle_endtag(self, tag):
        """End a cell or script."""
        if tag == "script":
            self._script = None
        if tag in ("td", "th"):
            self._in_cell = False

    def handle_data(self, text):
        """Add text to the cell it stands in; that of a script is data, or none."""
        if self._script is not None:
            if self._script.get("type") == "application/json":
                self.data[self._script["id"]] = json.loads(text)
            return
        self.text += text
        if self._in_cell:
            self._rows[-1][-1] += text
