"""Sentences of the report of a run, each made of its record."""

from math import tau

from cea.eigen.classify import GROWING, counted_words
from comparisons.kit.numbers import capitalised, counted, listed, number
from comparisons.kit.tables import Data


def unstable(data: Data) -> str:
    """How many modes have which word, and which grows fastest."""
    values = data["eigenvalues"]
    top = number(data["window"]["max_frequency"], 4)
    if not values:
        return f"{capitalised(data['summary'].partition(': ')[2])}."
    counts = counted_words(
        [v["verdict"] for v in values],
        [v["re"] for v in values],
        data["scene"]["analysis"].get("growth_threshold"),
    )
    fastest = max(values, key=lambda v: v["re"])
    more = (
        f"; mode {values.index(fastest) + 1} grows fastest, by {number(fastest['re'], 4)} 1/s at "
        f"{number(fastest['im'] / tau, 5)} Hz"
        if fastest["verdict"] in GROWING
        else ""
    )
    return f"{capitalised(counted(len(values), 'mode'))} up to {top} Hz: {counts}{more}."


def window(data: Data) -> str:
    """Why nothing is believed to be missing."""
    complete = (
        "The window is complete" if data["window"]["complete"] else "The window may lack modes"
    )
    return f"{complete}: {data['window']['evidence']}."


def errors(data: Data) -> str:
    """Largest residual and condition of all modes."""
    values = data["eigenvalues"]
    if not values:
        return "No mode was found."
    residual, condition = (max(v[key] for v in values) for key in ("residual", "condition"))
    return (
        f"The largest residual is {number(residual, 2)}, the largest condition number "
        f"{number(condition, 3)}."
    )


def size(data: Data) -> str:
    """Unknowns and run time."""
    slowest = max(data["timings"], key=data["timings"].__getitem__, default=None)
    text = f"{counted(data['dofs']['free'], 'dof')} took {number(data['seconds'], 3)} s"
    if slowest is None or not data["seconds"]:
        return f"{text}."
    share = 100 * data["timings"][slowest] / data["seconds"]
    return f"{text}, {number(share, 2)} % of it {_stage(slowest)}."


def _stage(name: str) -> str:
    return name.replace("krylov", "Krylov iteration").replace("_", " ")


def contact_points(data: Data) -> str:
    """How many contact points there are, and how many found nothing."""
    statuses = [found["status"] for found in data["contacts"].values()]
    points = sum(found["points"] for found in data["contacts"].values())
    missed = sum(status.get("missed", 0) for status in statuses)
    return (
        f"{capitalised(counted(points, 'contact point'))} in "
        f"{counted(len(statuses), 'pass', 'passes')}; {number(missed)} found nothing on the "
        "other side."
    )


def made_of(data: Data) -> str:
    """Bodies of the scene."""
    names = list(data["scene"].get("bodies", {}))
    return f"{capitalised(counted(len(names), 'body', 'bodies'))}: {listed(names)}."
