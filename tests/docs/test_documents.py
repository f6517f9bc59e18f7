"""Documents name files that exist, and what is said in two places is the same."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import cea
from comparisons.cli.app import COMMANDS, RENAMED

ROOT = Path(__file__).parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
ROOMS = ("cea", "fe_cea", "iga_cea", "exact_cea", "meshes", "scenes", "comparisons")
PLACES = (*ROOMS, "docs", "examples", "tests")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def named_files(text):
    """Paths in code type that begin in a folder of the project."""
    named = re.findall(r"`([\w./]+)`", text)
    return {path for path in named if path.split("/")[0] in PLACES and "/" in path}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_file_that_is_named_exists(document):
    text = document.read_text(encoding="utf-8")
    missing = [path for path in named_files(text) if not (ROOT / path).exists()]
    links = re.findall(r"\]\(([^):#]+)\)", text)
    missing += [link for link in links if not (document.parent / link).exists()]
    assert not missing


def test_every_command_that_is_named_exists():
    """Folders and options aside: the word after `cea` is a command, by the name it has now."""
    texts = [path.read_text(encoding="utf-8") for path in DOCUMENTS if path.name != "CHANGELOG.md"]
    named = {name for text in texts for name in re.findall(r"[`/ ]cea ([a-z]+)\b(?!/)", text)}
    assert "run" in named
    assert named & set(RENAMED) == set()
    assert named <= set(COMMANDS)


@pytest.mark.slow
def test_the_site_is_built_without_warnings(tmp_path):
    pytest.importorskip("sphinx", reason="the extra docs is not installed: make docs")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-b", "html", "docs", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True)
    assert "run_modes" in (tmp_path / "reference/python_api.html").read_text(encoding="utf-8")


def test_version_and_license_are_the_same_everywhere():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {cea.__version__}\n" in citation
    assert f"license: {PROJECT['project']['license']}\n" in citation
    assert "BSD 3-Clause" in (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_every_file_of_a_package_is_in_its_wheel_and_its_types_are_offered():
    packing, packed = PROJECT["tool"]["setuptools"], set()
    assert {name.rstrip("*") for name in packing["packages"]["find"]["include"]} == set(ROOMS)
    assert all((ROOT / name / "py.typed").is_file() for name in ROOMS)
    for package, patterns in packing["package-data"].items():
        for room in ROOMS if package == "*" else [package]:
            packed |= {path for pattern in patterns for path in (ROOT / room).glob(pattern)}
    every = [path for room in ROOMS for path in (ROOT / room).rglob("*.*") if path.is_file()]
    files = [path for path in every if path.suffix not in (".py", ".pyc")]
    assert [path for path in files if path not in packed] == []
