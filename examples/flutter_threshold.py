"""Friction at which two modes of two layers coalesce, computed and exact."""

from exact_cea.thresholds import mu_critical
from scenes import assemble, load_scene

MU = "contacts.interface.mu"


def threshold(backend: str) -> float:
    """Return the factor on the friction sin(pi x / 2) at which flutter below 0.5 Hz begins."""
    scene = load_scene("blocks", backend=backend).change(
        {MU: "sin(pi*x/2)", "analysis.max_frequency": 0.5}
    )
    return assemble(scene).threshold(MU, real=0.05, flutter=0.07).value


def exact_threshold() -> float:
    """Return the exact threshold."""
    return mu_critical("blocks", p=1, max_frequency=3.0)


if __name__ == "__main__":
    for backend in ("fe", "iga"):
        print(f"{backend:5}", threshold(backend))
    print("exact", exact_threshold())
