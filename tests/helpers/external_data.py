"""Data that nobody in this project made, beside the checkout; tests that need it skip without."""

import os
from pathlib import Path

import pytest

_BESIDE = Path(__file__).parents[2].parent / "shared" / "external"


def external(name):
    """Folder of a case, or the reason why there is none.

    The folder of all cases is `../shared/external`, or what `CEA_EXTERNAL` names.
    """
    folder = Path(os.environ.get("CEA_EXTERNAL", _BESIDE)) / name
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent: external data do not come with the project")
    return folder
