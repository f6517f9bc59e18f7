"""Numbers of the program as they were frozen in ``tests/golden``, and how they are compared.

As a program it compares the scenes with those of any command, and renews what changed on purpose::

    .venv/bin/python tests/helpers/golden.py .venv/bin/cea --only 'disc|drum'
    .venv/bin/python tests/helpers/golden.py .venv/bin/cea --only disc_pad_damped --renew
"""

import argparse
import gzip
import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from external_data import external

GOLDEN = Path(__file__).parents[1] / "golden"
PARTS = ("contacts", "stresses", "steady_sliding")
"""Parts of a result, beside its eigenvalues, whose numbers are compared."""


@cache
def stored():
    """Frozen scenes by name, plain data."""
    return json.loads(gzip.decompress((GOLDEN / "scenes.json.gz").read_bytes()))


def run_frozen(call, case, folder):
    """Content of ``result.json`` of a frozen case that a call with arguments runs in a folder.

    A case has the ``args`` of a scene that comes with the program, or the ``scene`` as TOML; where
    it names ``data``, a folder of data of others is needed too.
    """
    out, args = Path(folder) / "out", list(case.get("args", ()))
    if "scene" in case:
        file = Path(folder) / "scene.toml"
        file.write_text(case["scene"])
        args = ["run", str(file)]
    if "data" in case:
        args += ["--data", str(external(case["data"]))]
    call(*args, "--out", out)
    return json.loads((out / "result.json").read_text())


def frozen_numbers(result):
    """What is kept of a ``result.json``: eigenvalues with their uncertainty, numbers by path."""
    parts = [part for part in PARTS if result.get(part)]
    return {
        "eigenvalues": [
            [rounded(e[key]) for key in ("re", "im", "uncertainty")]
            for e in result.get("eigenvalues", [])
        ],
        "numbers": {part: dict(_leaves(result[part], part)) for part in parts},
    }


def rounded(value):
    """A number to twelve digits, far below every tolerance."""
    return float(f"{value:.12g}")


def _leaves(data, path):
    """Numbers of plain data with their paths."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _leaves(value, f"{path}.{key}")
    elif isinstance(data, list):
        for i, value in enumerate(data):
            yield from _leaves(value, f"{path}[{i}]")
    elif isinstance(data, int | float) and not isinstance(data, bool):
        yield path, rounded(data)


def differences(then, result):
    """What differs between frozen numbers and a ``result.json``, in words.

    Eigenvalues may move by ten times the uncertainty stated then, or 1e-10 relative; other numbers
    by 1e-7 of the largest number of their kind in the same part.
    """
    now = frozen_numbers(result)
    left = [complex(re_, im) for re_, im, _ in now["eigenvalues"]]
    if len(then["eigenvalues"]) != len(left):
        yield f"{len(left)} modes where there were {len(then['eigenvalues'])}"
    for real, imaginary, uncertainty in then["eigenvalues"]:
        if not left:
            break
        old = complex(real, imaginary)
        new = min(left, key=lambda each: abs(each - old))
        if abs(new - old) > max(1e-10 * abs(old), 10 * uncertainty):
            yield f"{old:.8g} moved by {abs(new - old):.1e}, uncertainty {uncertainty:.1e}"
        left.remove(new)
    for part, numbers in then["numbers"].items():
        found, sizes = now["numbers"].get(part, {}), {}
        for path, value in numbers.items():
            sizes[_kind(path)] = max(abs(value), sizes.get(_kind(path), 0.0))
        for path, value in numbers.items():
            if path not in found:
                yield f"{path} is gone"
            elif abs(found[path] - value) > 1e-7 * sizes[_kind(path)] + 1e-12:
                yield f"{path}: {found[path]:.10g} where it was {value:.10g}"


def _kind(path):
    """Path of a number without its places in lists."""
    return re.sub(r"\[\d+\]", "[]", path)


def main():
    """Compare or renew the frozen scenes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", help="the program, .venv/bin/cea of any checkout")
    parser.add_argument("--only", default="", help="pattern that names of cases contain")
    parser.add_argument("--renew", action="store_true", help="store the numbers found")
    options = parser.parse_args()
    cases = stored()

    def call(*arguments):
        subprocess.run([options.command, *arguments], stdout=subprocess.DEVNULL, check=True)

    for name, case in cases.items():
        if not re.search(options.only, name):
            continue
        with TemporaryDirectory() as folder:
            result = run_frozen(call, case, folder)
        found = list(differences(case, result))
        sys.stdout.write(f"{name}: {'; '.join(found[:4]) or 'equal'}\n")
        if options.renew:
            case |= frozen_numbers(result)
    if options.renew:
        text = json.dumps(cases, indent=0, sort_keys=True, ensure_ascii=False)
        (GOLDEN / "scenes.json.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    main()
