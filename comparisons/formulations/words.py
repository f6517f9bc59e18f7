"""Sentences of the page of formulations, each computed from the data it speaks of."""

from collections.abc import Iterable
from typing import Any

from comparisons.formulations.pairing_tables import change, pairing_name, refined_name, within
from comparisons.formulations.tables import passes_in_words
from comparisons.kit.numbers import capitalised, counted, listed, number, plain
from comparisons.kit.tables import Data
from scenes.names import backend_name

LOCKED = 10.0
"""A formulation locks where its error at the largest p is so many times its least, or an eigenvalue
is lost."""
KEPT = 1e-9
"""Largest relative loss of momentum that is round-off."""


def summary(data: Data) -> str:
    """The page in one paragraph."""
    return " ".join(
        (
            _who_passes(data),
            *(_who_locks(data, backend) for backend in _backends(data)),
            _who_keeps_momentum(data),
            _count_met(data),
            pairings_agree(data),
            f"All together took {number(data['seconds'])} s.",
        )
    )


def interfaces(data: Data) -> list[str]:
    """Interfaces of the patch tests."""
    return list(dict.fromkeys(run["interface"] for run in data["patch_tests"]["runs"]))


def patch_tests(data: Data, interface: str) -> str:
    """Which formulations pass on an interface: for every P, for some, for none."""
    part = data["patch_tests"]
    runs = [run for run in part["runs"] if run["interface"] == interface]
    every, never, some = [], [], []
    for name, own in _by_formulation(runs).items():
        if all(run["passes"] == part["P"] for run in own):
            every.append(name)
        elif not any(run["passes"] for run in own):
            never.append(name)
        else:
            count = sum(bool(run["passes"]) for run in own)
            passed = [P for P in part["P"] if any(P in run["passes"] for run in own)]
            which = passes_in_words(passed, part["P"])
            which = "every P" if passed == part["P"] else f"P = {which}"
            some.append(f"{name} ({which}; {count} of {counted(len(own), 'pair')} of meshes)")
    sentences = [
        f"On the {interface} interface {_those(every)} for every P and between all meshes."
    ]
    if some:
        sentences.append(f"For some P or meshes: {', '.join(some)}.")
    if never:
        sentences.append(f"Never: {'; '.join(never)}.")
    return " ".join(sentences)


def own_errors(data: Data) -> str:
    """What bodies and meshes leave of the test by themselves."""
    part = data["patch_tests"]
    own = max(part["runs"], key=lambda run: run["own_error"])
    if not own["own_error"]:
        return ""
    exact = [run for run in part["runs"] if run["formulation"] == "mortar"]
    sentence = (
        f"Bodies alone, the exact pressure a load on each, err by at most "
        f"{number(own['own_error'], 2)} ({own['interface']}, {_meshes(own)})."
    )
    left = [run for run in exact if run["passes"] != part["P"]]
    if left:
        worst = max(left, key=_largest)
        sentence += (
            f" Mortar itself does not pass everywhere: its error is up to "
            f"{number(_largest(worst), 2)} ({worst['interface']}, {_meshes(worst)})."
        )
    return sentence


def locking(data: Data) -> list[str]:
    """How errors change with p, backend by backend."""
    return [_locking(data["locking"], backend) for backend in _backends(data)]


def _locking(part: Data, backend: str) -> str:
    runs = [run for run in part["runs"] if run["backend"] == backend]
    ends = f"p = {number(part['p'][0], 1)} to {number(part['p'][-1], 1)}"
    free = [run for run in runs if not _locks(run)]
    sentences = []
    if locked := [run for run in runs if _locks(run)]:
        grown = "; ".join(f"{run['formulation']} ({_grown(run)})" for run in locked)
        sentences.append(
            f"{capitalised(backend_name(backend))}, {ends}: the error grows more than "
            f"{plain(LOCKED)} times, or an eigenvalue is lost, with {grown}."
        )
    if free:
        least = min(min(run["errors"]) for run in free)
        most = max(max(run["errors"]) for run in free)
        sentences.append(
            f"On {backend_name(backend)} it stays between {number(least, 2)} and "
            f"{number(most, 2)} with {_named(run['formulation'] for run in free)}."
        )
    return " ".join(sentences)


def momentum_lost(data: Data) -> str:
    """How much momentum contact forces lose, and by which formulation."""
    runs = data["patch_tests"]["runs"]
    linear = max(max(kind["linear"] for kind in run["momentum"].values()) for run in runs)
    losing = _losing(runs)
    keeping = [name for name in _by_formulation(runs) if name not in losing]
    sentences = [f"Contact forces lose at most {number(linear, 2)} of linear momentum, relative."]
    if losing:
        worst = _named(f"{name} (up to {number(value, 2)})" for name, value in losing.items())
        sentences.append(f"Normal forces lose angular momentum with {worst}.")
    if not keeping:
        return " ".join(sentences)
    sentences.append(f"They keep it to {number(KEPT, 1)} with {_named(keeping)}.")
    lost = dict.fromkeys(interfaces(data), 0.0)
    for run in runs:
        if run["formulation"] in keeping:
            here, defect = run["interface"], run["momentum"]["friction"]["angular"]
            lost[here] = max(lost[here], defect)
    most = listed(f"{number(value, 2)} on the {name} interface" for name, value in lost.items())
    sentences.append(f"Friction forces of these lose up to {most}.")
    return " ".join(sentences)


def paper_met(data: Data) -> str:
    """How many numbers of the paper are met, and which are not."""
    missed = [
        f"{figure}, {n['what']} (paper {_quoted(n['paper'])}, ours {number(n['ours'])})"
        for figure, n in _judged(data)
        if not n["met"]
    ]
    return f"{_count_met(data)} Not met: {'; '.join(missed)}." if missed else _count_met(data)


def paper_notes(data: Data) -> list[tuple[str, str]]:
    """Title of each figure and its note."""
    return [(figure["title"], figure["note"]) for figure in data["paper"]["figures"]]


def pairings_agree(data: Data) -> str:
    """Whether all pairings of backends find the same unstable modes."""
    part = data["pairings"]
    first = part["runs"][0]
    alone = sum(len(d["only_first"]) + len(d["only_second"]) for d in part["differences"])
    pairs = [pair for found in part["differences"] for pair in found["pairs"]]
    text = (
        f"Up to {plain(part['max_frequency'] / 1000)} kHz the disc and pad have "
        f"{counted(len(first['unstable']), 'unstable mode')} with {pairing_name(first)}"
    )
    if not pairs:
        return f"{text}; none has a partner in another pairing of backends."
    f, g = (max(abs(change(pair, key)) for pair in pairs) for key in ("frequency", "growth"))
    agree = sum(within(pair, part["bounds"]) for pair in pairs)
    return (
        f"{text}; the other {number(len(part['runs']) - 1)} pairings of backends "
        f"{'find the same' if not alone else f'leave {counted(alone, "mode")} without partner'}, "
        f"at most {number(100 * f, 2)} % in frequency and {number(100 * g, 2)} % in growth rate "
        f"from them: {number(agree)} of {counted(len(pairs), 'pair')} within "
        f"{plain(100 * part['bounds']['frequency'])} % and "
        f"{plain(100 * part['bounds']['growth'])} %."
    )


def not_converged(data: Data) -> list[str]:
    """What changes when the last pairing is run with a higher degree."""
    part = data["pairings"]
    last, found = part["runs"][-1], part["refined"]["difference"]
    sentences = []
    if last["unstable"]:
        mode = max(last["unstable"], key=lambda mode: mode["condition"])
        sentences.append(
            f"Of the modes of {pairing_name(last)} that at {_hertz(mode)} is the most sensitive: "
            f"its condition number, which has no bound where two modes coalesce, is "
            f"{number(mode['condition'], 2)}."
        )
    changed = [pair for pair in found["pairs"] if not within(pair, part["bounds"])]
    changed.sort(key=lambda pair: -abs(change(pair, "growth")))
    sentences += [
        f"The growth rate at {pair['frequency'][0]:.0f} Hz is not converged: with "
        f"{refined_name(part)}, it is {number(pair['growth'][1])} 1/s instead of "
        f"{number(pair['growth'][0])} 1/s."
        for pair in changed
    ]
    sentences += [
        f"The mode at {_hertz(mode)}, growth rate {number(mode['growth'])} 1/s, is not unstable "
        f"any more with {refined_name(part)}."
        for mode in found["only_first"]
    ]
    top = part["max_frequency"]
    sentences += [
        f"With {refined_name(part)}, there is one more at {_hertz(mode)}, "
        f"{number(100 * (1 - mode['frequency'] / top), 2)} % below the end of the window."
        for mode in found["only_second"]
    ]
    if not changed and not found["only_first"] and not found["only_second"]:
        sentences.append(f"With {refined_name(part)}, all of them stay within the bounds.")
    return sentences


def _who_passes(data: Data) -> str:
    """Which formulations pass every patch test, which none."""
    part = data["patch_tests"]
    groups = _by_formulation(part["runs"])
    parts = []
    for interface in interfaces(data):
        every = [
            name
            for name, runs in groups.items()
            if all(r["passes"] == part["P"] for r in runs if r["interface"] == interface)
        ]
        parts.append(f"on the {interface} interface {_those(every)}")
    return (
        f"Patch test, for all P from {number(part['P'][0], 1)} to {number(part['P'][-1], 1)} N/m "
        f"and between all meshes: {'; '.join(parts)}."
    )


def _who_locks(data: Data, backend: str) -> str:
    runs = [run for run in data["locking"]["runs"] if run["backend"] == backend]
    locked = [run["formulation"] for run in runs if _locks(run)]
    free = [run["formulation"] for run in runs if not _locks(run)]
    return (
        f"On {backend_name(backend)} error grows as contact stiffens with "
        f"{_named(locked) or 'none'}; it does not with {_named(free) or 'any'}."
    )


def _who_keeps_momentum(data: Data) -> str:
    losing = _losing(data["patch_tests"]["runs"])
    if not losing:
        return "Normal contact forces keep momentum with all."
    return f"Normal contact forces keep angular momentum with all but {_named(losing)}."


def _losing(runs: list[Data]) -> dict[str, float]:
    """Formulations whose normal forces lose angular momentum, and how much at most."""
    defects = {
        name: max(run["momentum"]["normal"]["angular"] for run in own)
        for name, own in _by_formulation(runs).items()
    }
    return {name: defect for name, defect in defects.items() if defect > KEPT}


def _count_met(data: Data) -> str:
    judged = _judged(data)
    met = sum(n["met"] for _, n in judged)
    return f"{number(met)} of {counted(len(judged), 'number')} of the paper are met."


def _judged(data: Data) -> list[tuple[str, Data]]:
    """Numbers of the paper with a verdict, and the name of their figure."""
    return [
        (figure["title"].partition(":")[0], n)
        for figure in data["paper"]["figures"]
        for n in figure["numbers"]
        if n["met"] is not None
    ]


def _locks(run: Data) -> bool:
    errors = run["errors"]
    return None in errors or errors[-1] > LOCKED * min(errors)


def _grown(run: Data) -> str:
    first, last = (run["errors"][i] for i in (0, -1))
    return f"{number(first, 2)} to {number(last, 2) if last is not None else 'a lost eigenvalue'}"


def _backends(data: Data) -> list[str]:
    return list(dict.fromkeys(run["backend"] for run in data["locking"]["runs"]))


def _by_formulation(runs: Iterable[Data]) -> dict[str, list[Data]]:
    groups: dict[str, list[Data]] = {}
    for run in runs:
        groups.setdefault(run["formulation"], []).append(run)
    return groups


def _largest(run: Data) -> float:
    return max((error for error in run["errors"] if error is not None), default=0.0)


def _meshes(run: Data) -> str:
    return " on ".join(run["meshes"])


def _those(names: list[str]) -> str:
    """Formulations that pass, as the beginning of a sentence."""
    if not names:
        return "none passes"
    return f"{listed(names)} {'passes' if len(names) == 1 else 'pass'}"


def _named(names: Iterable[str]) -> str:
    """Names that hold commas, set apart."""
    return "; ".join(names)


def _hertz(mode: Data) -> str:
    return f"{mode['frequency']:.0f} Hz"


def _quoted(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:g}"
