"""A study of squares, for tests of the engine: it notes what it computes, fails, crashes, hangs."""

import os
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from cea.errors import ConvergenceError
from cea.petsc import MPI
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Process, Study


@dataclass(frozen=True)
class Options:
    """Options of it."""

    sizes: Annotated[tuple[int, ...], "What is squared."] = (1, 2, 3)
    factor: Annotated[float, "Factor of all."] = 1.0
    power: Annotated[int, "Exponent."] = 2
    log: Annotated[str, "File in which cases are noted."] = ""


def cases(options):
    for size in options.sizes:
        yield {"size": size, "kind": "<odd>" if size % 2 else "even"}


def on_ranks(options):
    for size in options.sizes:
        yield {"size": size, "ranks": size}


def evaluate(case, session):
    options, size = session.options, case["size"]
    if options.log:
        with Path(options.log).open("a") as file:
            file.write(f"{size}\n")
    if size == 13:
        raise ConvergenceError("unlucky")
    if size == 666:
        os._exit(7)
    if size == 999:
        time.sleep(60)
    if size == 404:
        return {"square": float("nan")}
    session.keep("powers", np.arange(size))
    ranks = MPI.COMM_WORLD.allreduce(1)
    square = np.float64(options.factor * size**options.power)
    return {"square": None if size == 5 else square, "ranks": ranks}


def headline(result):
    return f"The largest is {result.frame()['square'].max():g}."


OWN = {"square": Column("square & more", "m²")}
TABLE = Table("squares", "All <squares>.", "runs", OWN)
PLOT = Plot("squares", "Growth.", "runs", "size", "square", ("kind",), log="y")
STUDY = Study(
    "squares",
    "Squares <of> numbers",
    Options,
    cases,
    evaluate,
    [
        Section("Squares", "Text & more.", headline, [TABLE], [PLOT]),
        Section("Nothing", "No table.", lambda r: r.frame("none")["lost"].max(), of="none"),
    ],
    quick={"sizes": (2,)},
    check=lambda result: "too large" if result.frame()["square"].max() > 1e3 else "",
)
APART = replace(
    STUDY,
    cases=on_ranks,
    evaluate=lambda case, session: {"together": MPI.COMM_WORLD.allreduce(1)},
    process=Process("small_study:APART", 20.0),
)
HASTY = replace(STUDY, process=Process("small_study:HASTY", 3.0))
