"""The deck of Abaqus against the grammar of its manual: keywords, parameters, data, places.

The program itself is not run.
"""

import re

import decks
import numpy as np
import pytest
from deck_scenes import ELEMENTS, ROUND, alone, in_contact

from scenes.export.decks.write import write_deck

LABEL = r"[A-Za-z][\w-]{0,79}"
NUMBER = r"[+-]?\d+(\.\d*)?([Ee][+-]?\d+)?"
WHOLE = r"\d+"
SET = f"({LABEL}|{WHOLE})"
MODEL, STEP = "model", "step"


def fields(*patterns):
    """A data line with so many fields; "" may be left out."""
    return re.compile(r"\s*,\s*".join(patterns) + r"\s*,?")


GRAMMAR = {
    "HEADING": (MODEL, {}, [re.compile(".*")]),
    "NODE": (MODEL, {"NSET": LABEL}, [fields(WHOLE, NUMBER, NUMBER, NUMBER)]),
    "ELEMENT": (
        MODEL,
        {"TYPE": "C3D4|C3D8|C3D10|CPE3|CPE4|CPE6", "ELSET": LABEL},
        [re.compile(rf"{WHOLE}(,{WHOLE}){{3,10}}")],
    ),
    "NSET": (MODEL, {"NSET": LABEL}, [re.compile(rf"{WHOLE}(,{WHOLE}){{0,15}}")]),
    "SURFACE": (MODEL, {"NAME": LABEL, "TYPE": "ELEMENT"}, [fields(WHOLE, "S[1-6]")]),
    "TRANSFORM": (MODEL, {"NSET": LABEL, "TYPE": "C"}, [fields(*6 * [NUMBER])]),
    "MATERIAL": (MODEL, {"NAME": LABEL}, []),
    "ELASTIC": (MODEL, {}, [fields(NUMBER, NUMBER)]),
    "DENSITY": (MODEL, {}, [fields(NUMBER)]),
    "SOLID SECTION": (MODEL, {"ELSET": LABEL, "MATERIAL": LABEL}, [fields(NUMBER)]),
    "SURFACE INTERACTION": (MODEL, {"NAME": LABEL}, []),
    "SURFACE BEHAVIOR": (MODEL, {"PRESSURE-OVERCLOSURE": "LINEAR"}, [fields(NUMBER)]),
    "CONTACT PAIR": (
        MODEL,
        {"INTERACTION": LABEL, "TYPE": "SURFACE TO SURFACE", "SMALL SLIDING": ""},
        [fields(LABEL, LABEL)],
    ),
    "CLEARANCE": (MODEL, {"MASTER": LABEL, "SLAVE": LABEL, "VALUE": NUMBER}, []),
    "BOUNDARY": (None, {"OP": "NEW|MOD"}, [fields(SET, "[1-3]", "[1-3]")]),
    "FRICTION": (None, {}, [fields(NUMBER)]),
    "STEP": (MODEL, {"UNSYMM": "YES"}, []),
    "STATIC": (STEP, {}, [fields(NUMBER, NUMBER)]),
    "CHANGE FRICTION": (STEP, {"INTERACTION": LABEL}, []),
    "MOTION": (
        STEP,
        {"ROTATION": "", "TRANSLATION": "", "TYPE": "VELOCITY"},
        [fields(SET, *7 * [NUMBER]), fields(SET, "[1-3]", "[1-3]", NUMBER)],
    ),
    "FREQUENCY": (STEP, {"EIGENSOLVER": "LANCZOS"}, [fields(WHOLE, "", NUMBER)]),
    "COMPLEX FREQUENCY": (STEP, {"FRICTION DAMPING": "NO"}, [fields(WHOLE, "", NUMBER)]),
    "END STEP": (STEP, {}, []),
}
"""Where a keyword may stand (None, in both), parameters that it may have with their values, and its
data lines: what the manual allows, as far as decks need it."""
PROCEDURES = ("STATIC", "FREQUENCY", "COMPLEX FREQUENCY")
FOLLOWS = {"ELASTIC": "MATERIAL", "DENSITY": "ELASTIC", "SURFACE BEHAVIOR": "SURFACE INTERACTION"}
"""Keywords that belong to the one before."""


def faults(file):
    """What the grammar does not allow, line by line; included files stand in their place."""
    place, found, card, before = MODEL, [], None, ""
    for line in lines(file):
        if not line.startswith("*"):
            shapes = GRAMMAR[card][2]
            if not any(shape.fullmatch(line) for shape in shapes):
                found.append(f"*{card}: {line}")
            continue
        words = [word.strip() for word in line[1:].split(",")]
        before, card = card, words[0]
        if card not in GRAMMAR:
            return [*found, line]
        where, parameters, _ = GRAMMAR[card]
        if where not in (None, place):
            found.append(f"{line} in the {place}")
        if card in FOLLOWS and before != FOLLOWS[card]:
            found.append(f"{line} after *{before}")
        for word in words[1:]:
            name, _, value = (part.strip() for part in word.partition("="))
            if name not in parameters or not re.fullmatch(parameters[name], value):
                found.append(line)
        place = {"STEP": STEP, "END STEP": MODEL}.get(card, place)
    return found if place == MODEL else [*found, "a step without end"]


def lines(file):
    """Lines of a deck that are no comments."""
    for line in file.read_text(encoding="ascii").splitlines():
        assert len(line) <= 256
        if line.startswith("*INCLUDE, INPUT="):
            yield from lines(file.with_name(line.partition("=")[2]))
        elif line and not line.startswith("**"):
            yield line


def steps(file):
    """Cards of each step."""
    found = []
    for card in decks.cards(file):
        if card.keyword == "STEP":
            found.append([])
        elif found:
            found[-1].append(card)
    return found


@pytest.mark.parametrize("name", ELEMENTS)
def test_decks_of_one_body_are_as_the_manual_has_it(name, tmp_path):
    supports = ROUND if name.startswith("C3D") else None
    file = write_deck(alone(*ELEMENTS[name], supports=supports), tmp_path)[2]
    assert faults(file) == []
    ((frequency, *_),) = steps(file)
    assert frequency.rows == [["20", "10000.0"]]


@pytest.mark.parametrize("mu", [0.7, 0.0])
def test_decks_of_contacts_are_as_the_manual_has_it(mu, tmp_path):
    file = write_deck(in_contact(**{"contacts.pad_disc.mu": mu}), tmp_path)[2]
    assert faults(file) == []
    procedures = [[c.keyword for c in step if c.keyword in PROCEDURES] for step in steps(file)]
    sliding = [["STATIC"], ["STATIC"], ["FREQUENCY"], ["COMPLEX FREQUENCY"]]
    assert procedures == (sliding if mu else [["STATIC"], ["FREQUENCY"]])
    assert bool(decks.of(decks.cards(file), "FRICTION")) == bool(mu)


def test_static_steps_hold_every_node_and_the_frequency_step_frees_all_but_the_supports(tmp_path):
    file = write_deck(in_contact(), tmp_path)[2]
    closed, sliding, free, flutter = steps(file)
    (held,) = decks.of(closed, "BOUNDARY")
    assert held.parameters == {"OP": "NEW"}
    assert held.rows == [["pad", "1", "3"], ["disc", "1", "3"]]
    assert not decks.of(sliding, "BOUNDARY")
    assert not decks.of(flutter, "BOUNDARY")
    (supports,) = decks.of(free, "BOUNDARY")
    assert supports.parameters == {"OP": "NEW"}
    assert supports.rows == [["pad-top", "1", "3"], ["disc-inner", "1", "3"]]


def test_abaqus_is_told_the_motion_that_pushes_the_pad_as_the_scene_says(tmp_path):
    deck = decks.cards(write_deck(in_contact(), tmp_path)[2])
    (motion,) = decks.of(deck, "MOTION")
    assert "ROTATION" in motion.parameters
    name, rate, *axis = motion.rows[0]
    assert name == "disc"
    chord = 0.09 * np.cos(np.radians(40 / 6))  # where a node is nearest to the axis
    assert float(rate) == pytest.approx(1 / chord)  # positive: along the friction on the pad
    assert [float(word) for word in axis] == [0, 0, 0, 0, 0, 1]
    (complex_,) = decks.of(deck, "COMPLEX FREQUENCY")
    assert complex_.parameters["FRICTION DAMPING"] == "NO"
