"""A fault on one rank ends the others, of whatever kind it is."""

import pickle

import pytest
from mpi import on_ranks

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from cea.ranks import FaultOnRankError, agreed, made_on_first
from scenes.spec.problems import SceneError


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_every_rank_hears_of_a_fault_on_one(ranks):
    for kind, heard in on_ranks(ranks, "rank_faults.every").items():
        expected = "FaultOnRankError" if kind == "UnpackableError" else kind
        assert set(heard[:-1]) == {expected}
        assert heard[-1] == kind


def test_a_process_alone_meets_its_own_fault():
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        with pytest.raises(ZeroDivisionError), agreed(comm):
            _ = 1 / 0
        with pytest.raises(ZeroDivisionError):
            made_on_first(comm, lambda: 1 / 0)
    assert made_on_first(MPI.COMM_SELF, lambda: 3) == 3
    assert issubclass(FaultOnRankError, RuntimeError)


@pytest.mark.parametrize(
    "error",
    [
        InputError("mu", -1.0, "zero or positive"),
        SceneError([InputError("mu", -1.0, "zero or positive"), InputError("p", 0, "positive")]),
        ConvergenceError("none"),
    ],
)
def test_errors_travel(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    if isinstance(error, SceneError):
        assert [fault.field for fault in again.faults] == ["mu", "p"]
