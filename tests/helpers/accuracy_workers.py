"""What measures in a worker's process and fails in each way a case can."""

import os
from time import sleep


class Failing:
    """Fails as the rule of the case's method says."""

    def measure(self, case, exact, repeats):
        """Tell the surroundings, or fail."""
        match case.method.rule:
            case "node":
                raise ValueError("no nodes here\nsecond line")
            case "grid":
                os._exit(3)
            case "greville":
                sleep(60)
        return {"threads": os.environ["OMP_NUM_THREADS"], "modes": len(exact), "repeats": repeats}


def failing():
    """Make what fails as it measures."""
    return Failing().measure
