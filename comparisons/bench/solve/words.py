"""What the methods show, in sentences made of the data."""

from statistics import median

from comparisons.bench.solve.study import OURS
from comparisons.bench.solve.tables import in_factorisations, ran
from comparisons.kit.numbers import counted, number
from comparisons.kit.tables import Data

TITLE = "Eigenvalues of a window beside other methods"


def summary(data: Data) -> str:
    """Time and worst error of each method."""
    told = [
        f"{method['name']}: {number(median(method['processor']), 3)} s "
        f"({number(in_factorisations(method), 3)} LU), worst error "
        f"{number(max(method['errors']), 2)}"
        for method in ran(data)
    ]
    ours = next(method for method in ran(data) if method["name"] == OURS)
    on = counted(data["inputs"]["ranks"], "rank")
    return (
        f"{counted(data['unknowns'], 'unknown')}, {counted(len(ours['eigenvalues']), 'mode')}, "
        f"{on}. {'; '.join(told)}. Tightest: {data['tightest']}."
    )
