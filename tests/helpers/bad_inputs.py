"""Bad input for what reads scenes, paths of `--set`, files and expressions."""

import signal
from contextlib import contextmanager
from time import perf_counter

import numpy as np
from scene_mutations import HOSTILE, NAMES, Bad, drawn, places, random_mutation, text_of, valid

from cea.errors import ConvergenceError, InputError
from cea.expressions import Expression
from scenes import open_result
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds on a machine with nothing else."""
REFUSALS = (InputError, SceneError, ConvergenceError)
SETTINGS = [
    *("nan", "inf", "-1", "1e400", "[", "{", "{a=1}", "[[[]]]", "'", '"""', "1\nb=2", "true"),
    *("1979-05-27", "07:32:00", "[" * 3000, "9" * 5000, "x" * 5000, "\ud800", "", "\0"),
]
"""Values that a setting may be given."""


@contextmanager
def patience(seconds=PATIENCE):
    """Stop what hangs; a TimeoutError is no refusal."""

    def ring(*_):
        raise TimeoutError("hangs")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def faults_of(error):
    """The faults that a refusal tells."""
    return error.faults if isinstance(error, SceneError) else (error,)


def complaint(bad, read):
    """What is wrong with how an input was met, in words; None where all is well.

    A refusal is told in short lines that name a field. Anything else raised is a crash.
    """
    start = perf_counter()
    try:
        with patience():
            read(bad.value)
    except REFUSALS as error:
        lines = str(error).splitlines()
        if isinstance(error, InputError | SceneError):
            faults = faults_of(error)
            if not faults or not all(fault.field and fault.allowed for fault in faults):
                return f"{bad.words}: refused without a name: {error}"
            if bad.refused and bad.place and not _near(bad.place, faults):
                return f"{bad.words}: refused under another name: {lines[0]}"
            if len(lines) > 21 or max(map(len, lines)) > 2500:
                return f"{bad.words}: a refusal of {len(str(error))} characters"
        return None
    except Exception as error:
        return f"{bad.words}: {type(error).__name__}: {str(error)[:200]}"
    if bad.refused:
        return f"{bad.words}: accepted in {perf_counter() - start:.2f} s"
    return None


def _near(place, faults):
    """Whether some fault is told under the section that is wrong, or one of its own."""
    section = ".".join(map(str, place[:2]))
    return any(f.field.startswith((section, str(place[0]))) for f in faults)


ALPHABET = "xyzr 0123456789.+-*/()[]{},:;'\"\\_=<>&|~^%!@#$\n\0éｘ∞"


def random_expression(rng):
    """A hostile text, whole or cut and joined; or characters that are no expression."""
    if rng.random() < 0.5:
        first, second = str(drawn(rng, HOSTILE)), str(drawn(rng, HOSTILE))
        text = first if rng.random() < 0.5 else first[: rng.integers(1, 40)] + second
    else:
        text = "".join(drawn(rng, ALPHABET) for _ in range(rng.integers(1, 60)))
    return Bad("expression", f"expression {text[:60]!r}", text, True if text in HOSTILE else None)


def random_override(rng):
    """A setting of `--set` along a path that is there, broken or made up."""
    data = valid(str(rng.choice(NAMES)))
    parts = [str(key) for key in drawn(rng, list(places(data)))]
    for _ in range(rng.integers(0, 3)):
        where = int(rng.integers(len(parts) + 1))
        parts.insert(where, drawn(rng, ["", "0", "99", "-1", "x", "a b", "\0", "9" * 30, "é"]))
    value = drawn(rng, SETTINGS)
    return Bad("override", f"{'.'.join(parts)}={value[:20]}", (data["name"], parts, value), None)


def random_file(rng, whole):
    """Bytes of a file cut, changed, or mixed with others: a scene, or a stored result."""
    content = bytearray(whole)
    what = int(rng.integers(4))
    if what == 0:
        del content[int(rng.integers(len(content))) :]
    elif what == 1:
        for _ in range(int(rng.integers(1, 20))):
            content[int(rng.integers(len(content)))] = int(rng.integers(256))
    elif what == 2:
        start = int(rng.integers(len(content)))
        content[start : start + int(rng.integers(200))] = rng.bytes(int(rng.integers(200)))
    else:
        content = bytearray(rng.bytes(int(rng.integers(3000))))
    return bytes(content)


def reader(kind, folder):
    """What reads each kind of input; files go through a folder."""

    def override(value):
        name, parts, text = value
        return load_scene(name, [f"{'.'.join(parts)}={text}"])

    def scene_file(content):
        (folder / "scene.toml").write_bytes(content)
        return load_scene(folder / "scene.toml")

    def stored(content):
        (folder / "result.json").write_bytes(content)
        return open_result(folder / "result.json")

    return {
        "scene": read_scene,
        "expression": lambda text: Expression(text)(np.full((3, 3), 0.4)),
        "override": override,
        "scene file": scene_file,
        "stored": stored,
    }[kind]


def random_bad(rng, stored):
    """One input of any kind.

    Parameters
    ----------
    rng
        Random numbers.
    stored
        Content of a stored result.
    """
    kind = float(rng.random())
    if kind < 0.5:
        return random_mutation(rng)
    if kind < 0.6:
        return random_expression(rng)
    if kind < 0.7:
        return random_override(rng)
    if kind < 0.8:
        whole = text_of(str(rng.choice(NAMES))).encode()
        content = random_file(rng, whole)
        return Bad("scene file", f"scene file {content[:40]!r}", content, None)
    content = random_file(rng, stored)
    return Bad("stored", f"stored result {content[:40]!r}", content, None)
