"""A reduced model of what is mapped, filled until its bounds are small and full solves agree."""

from collections.abc import Callable, Iterable, Sequence
from time import process_time
from typing import Any, Protocol

from cea.errors import ConvergenceError, InputError
from cea.reduced.greedy import Enrichment, Point, Snapshot
from cea.reduced.model import ReducedModel
from cea.reduced.stored import arrays_of
from comparisons.sweep.map_record import Timed
from comparisons.sweep.mapped import Mapped
from comparisons.sweep.store import Store
from comparisons.sweep.thrift import Thrift

AT_FIRST = 0.5
"""Bound, relative to the tolerance, of a basis where it is made: elsewhere it is larger."""
_ROUNDS = 4
"""Times that full solves may find fault with a basis before it is given up."""


class Asked(Protocol):
    """How well a model is to be filled."""

    @property
    def tolerance(self) -> float:
        """Error of lambda, relative to its speed, up to which a value is certified."""
        ...

    @property
    def most(self) -> int:
        """Most full solves."""
        ...


def check_effort(tolerance: float, **counts: tuple[int, int]) -> None:
    """Refuse a tolerance out of reach, and counts of full solves, each given with its least.

    Raises
    ------
    InputError
        Naming the one that is out of range.
    """
    if not 1e-13 <= tolerance <= 1e-2:
        raise InputError("tolerance", tolerance, "1e-13 to 1e-2")
    for name, (count, least) in counts.items():
        if count < least:
            raise InputError(name, count, f"{least} or more")


class Filling:
    """A reduced model that full solves fill; those that a store holds are taken over.

    Parameters
    ----------
    asked
        How well.
    scene
        What is mapped.
    store
        Keeps what each full solve adds.
    progress
        Called with what begins.
    thrift
        Weighs the basis while it is made; None where it is wanted at any price.

    Attributes
    ----------
    model, basis
        The reduced model, and what enriches it.
    kept
        Full solves that the store held.

    Raises
    ------
    InputError
        When the store holds what is of something else.
    """

    def __init__(
        self,
        asked: Asked,
        scene: Mapped,
        store: Store,
        progress: Callable[[str], None],
        thrift: Thrift | None = None,
    ) -> None:
        self._scene, self._store, self._progress = scene, store, progress
        self._thrift = thrift
        self._most = asked.most
        self.model = ReducedModel(scene.pencil, scene.box, scene.max_frequency, scene.min_growth)
        self._full = Timed(scene)
        self.basis = Enrichment(
            self.model,
            self._full,
            scene.max_frequency,
            asked.tolerance,
            asked.most,
            keep=self._keep,
            tell=self._tell,
        )
        self.kept = 0
        self._begun = process_time()
        stored = store.snapshots()
        if stored:
            progress(f"{len(stored)} full solves, stored before")
            try:
                self.basis.restore(stored, store.arrays())
            except (KeyError, ValueError) as error:
                allowed = f"without what an interrupted sweep of something else left ({error})"
                raise InputError("out", str(store.folder), allowed) from error
            self.kept = len(stored)

    def fill(self, training: Sequence[Point], picked: Callable[[], Iterable[Point]]) -> None:
        """Enrich the basis until bounds are small and full solves agree with them.

        Parameters
        ----------
        training
            Points at which bounds are looked at.
        picked
            Gives points at which full solves test the model, others each time.

        Raises
        ------
        BasisTooDearError
            When full solves at all values are cheaper than the basis.
        ConvergenceError
            When full solves keep passing the bounds.
        """
        for _ in range(_ROUNDS):
            self.basis.cover(training, AT_FIRST * self.basis.tolerance)
            self._thrift = None
            if self.spent or self.basis.confirm(list(picked())):
                return
        raise ConvergenceError(
            f"full solves found modes or errors that the reduced model had not told of, "
            f"{_ROUNDS} times; more solves at first, or a lower max_frequency, may help"
        )

    def improve(self, points: Sequence[Point]) -> bool:
        """Solve where values are not certified, the worst first; whether that helped."""
        failed = [point for point, _ in self.basis.failed]
        points = [point for point in points if point not in failed]
        if not points or self.spent:
            return False
        size = self.model.size
        self.basis.cover(points)
        return self.model.size > size

    @property
    def spent(self) -> bool:
        """Whether there were as many full solves as there may be."""
        return len(self.basis.snapshots) >= self._most

    def seconds(self, online: float) -> tuple[float, float]:
        """Processor seconds of full solves, and of the basis: all but these and those online."""
        full = self._full.seconds
        return full, max(process_time() - self._begun - full - online, 0.0)

    def _keep(self, snapshot: Snapshot) -> None:
        self._store.keep(snapshot, arrays_of(self.model.small))

    def _tell(self, point: Any, worst: float) -> None:
        shown = ", ".join(f"{name} = {value:.4g}" for name, value in point.items())
        if self._thrift is not None:
            self._weigh(self._thrift, point, worst)
        self._progress(f"full solve {len(self.basis.snapshots) + 1}: {shown}, bound {worst:.1e}")

    def _weigh(self, thrift: Thrift, point: Point, worst: float) -> None:
        """Go on with the basis, or give it up: the same on every rank."""
        full, basis = self.seconds(0.0)
        before = process_time()
        self.model.small.at(self.model.pencil.values(point))
        value = process_time() - before
        full, basis, value = self.model.norm.comm.bcast((full, basis, value))
        thrift.weigh(worst, len(self.basis.snapshots) - self.kept, full, basis, value)

    def free(self) -> None:
        """Free factors."""
        self.model.free()
        self._scene.driver.free()
