"""One thing that was looked at."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Parameters
    ----------
    name
        What it is.
    told
        What was found.
    mend
        The command, or what else is to be done, where it is a fault; None where all is well.
    """

    name: str
    told: str
    mend: str | None = None

    @property
    def well(self) -> bool:
        """Whether all is well."""
        return self.mend is None
