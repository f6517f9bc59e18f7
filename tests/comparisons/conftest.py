"""A command of the command line, as a person calls it."""

import sys

import pytest

from comparisons.cli.app import main


@pytest.fixture
def cea(monkeypatch, capsys, tmp_path):
    """A command in an empty folder: its code, what it writes, what it tells of faults."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["cea", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        written = capsys.readouterr()
        return end.value.code or 0, written.out, written.err

    return run
