"""A program in a process of its own: what it is asked there, and what it answers."""

import gc
from collections.abc import Callable
from importlib import import_module
from time import perf_counter, process_time
from typing import Any

from comparisons.bench import memory
from comparisons.bench.annulus import Discretisation
from comparisons.bench.assembly.programs.assembler import Program
from comparisons.bench.assembly.programs.checks import (
    checked,
    lowest_eigenvalues,
    of_every_component,
)

_BYTES = 12
"""Bytes of an entry of a compressed matrix: a double and the number of its column."""

Answer = Callable[..., dict[str, Any]]


def answers() -> Answer:
    """What answers in the process of a program."""
    return _answer


def _answer(
    question: str, module: str, discretisation: Discretisation, *arguments: Any
) -> dict[str, Any]:
    """Answer a question about one program.

    Parameters
    ----------
    question
        ``time`` or ``check``.
    module
        The module whose ``lay_out`` is the program.
    discretisation, arguments
        What the question takes.
    """
    program: Program = import_module(module).lay_out
    answers_of: dict[str, Answer] = {"time": timed, "check": check}
    return answers_of[question](program, discretisation, *arguments)


def timed(program: Program, discretisation: Discretisation) -> dict[str, float]:
    """What one assembly of stiffness and mass takes.

    Returns
    -------
    dict
        Processor seconds of ``stiffness`` and of ``mass``, seconds of both by the ``clock``;
        ``peak``, the largest memory over that before (bytes), ``finished``, what the matrices hold
        (bytes); ``dofs``.
    """
    assembler = program(discretisation)
    gc.collect()
    memory.forget_largest()
    before, clock, begun = memory.held(), perf_counter(), process_time()
    K = assembler.stiffness()
    between = process_time()
    M = assembler.mass()
    end, clock = process_time(), perf_counter() - clock
    peak = memory.largest() - before
    entries = [assembler.compressed(matrix) for matrix in (K, M)]
    return {
        "stiffness": between - begun,
        "mass": end - between,
        "clock": clock,
        "peak": float(peak),
        "finished": float(_BYTES * sum(matrix.nnz for matrix in entries)),
        "dofs": float(entries[0].shape[0]),
    }


def check(program: Program, discretisation: Discretisation, modes: int) -> dict[str, Any]:
    """What the matrices do to rigid motions, and their lowest eigenvalues, so many of them."""
    assembler = program(discretisation)
    K = assembler.compressed(assembler.stiffness())
    M = of_every_component(assembler.compressed(assembler.mass()), K.shape[0])
    found = checked(K, M, assembler.motions())
    return found | {"eigenvalues": lowest_eigenvalues(K, M, modes)}
