"""``cea converge``: bars of sequences, what comes next, verdicts on modes."""

from dataclasses import replace
from math import exp, inf, log

import numpy as np
import pytest

from comparisons.converge.bars import Usual, bar, observed_rate, typical_rate
from comparisons.converge.combined import combine
from comparisons.converge.following import Sequence, clusters, lost, partners
from comparisons.converge.histories import Window
from comparisons.converge.judged import Judged, judge, shortfall
from comparisons.converge.levels import Level
from comparisons.converge.quantities import Member
from comparisons.converge.request import Request
from comparisons.converge.steps import Step, cheapest, chosen, steps
from comparisons.converge.theory import Fallen, fallen, reduction
from comparisons.kit.progress import Progress
from scenes.read import load_scene
from scenes.refinement import Resolution

SILENT = Progress(step=lambda _: None, stage=lambda _: None)
MU_CRITICAL = 0.05989842834808168909
"""Exactly known threshold of flutter of the scene ``blocks`` (cea exact blocks --thresholds)."""


def sequence(rows, scene="blocks", backend="iga"):
    """A sequence whose eigenvalues on meshes of doubled density are given, all modes linked."""
    made = Sequence(backend)
    for i, row in enumerate(rows):
        values = np.array(row, complex)
        made.levels.append(
            Level(
                backend,
                Resolution(2, 2.0**i),
                load_scene(scene),
                100 * 4**i,
                1.0,
                1.0,
                values,
                np.full(len(values), 1e-14),
                np.full(len(values), 1e-15),
                np.abs(values) <= 1e-14,
                True,
                None,
            )
        )
        if i:
            made.links.append([(np.array([n]), np.array([n])) for n in range(len(values))])
    return made


def converging(value, error, rate=1.0, count=4):
    """Numbers whose error falls as theory says for degree 2 and twice the elements, to a rate."""
    return [value * (1 + error * 16.0 ** (-rate * i)) for i in range(count)]


# Bars of sequences


@pytest.mark.parametrize("rate", [0.4, 0.7, 1.0])
def test_observed_rate_is_that_of_the_sequence(rate):
    positions = [0.0, 2.0, 3.0]
    numbers = [7.0 + exp(-rate * t) for t in positions]
    assert observed_rate(positions, np.abs(np.diff(numbers))) == pytest.approx(rate, rel=1e-9)


@pytest.mark.parametrize("values", [[1, 1.1], [1, 1.1, 1.11], [1, 1.1, 1.3], [1, 1.1, 1.11, 1.111]])
def test_bars_of_few_meshes_are_tripled_where_errors_were_not_measured_in_parts(values):
    positions = [float(i) for i in range(len(values))]
    known = bar(values, positions, 1.0).size
    doubt = 3.0 if len(values) < 4 else 1.0
    found = bar(values, positions, 1.0, usual=Usual(unmeasured=True)).size
    assert found == pytest.approx(doubt * known)


@pytest.mark.parametrize("rate", [0.4, 0.7, 0.9])
def test_bar_is_four_times_the_error_of_a_sequence_that_keeps_its_rate(rate):
    positions = [0.0, 2.0, 4.0, 5.0]
    numbers = [7.0 + exp(-rate * t) for t in positions]
    found = bar(numbers, positions, rate)
    assert found.size == pytest.approx(4 * exp(-rate * 5.0), rel=1e-6)
    assert found.rate == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("rate", [1.0, 3.0])
def test_bar_never_trusts_more_than_nine_tenths_of_theory(rate):
    positions = [0.0, 1.0, 2.0]
    numbers = [7.0 + exp(-rate * t) for t in positions]
    last = abs(numbers[-1] - numbers[-2])
    assert bar(numbers, positions, rate).size >= 3 * last / np.expm1(0.9) * (1 - 1e-12)


def test_where_no_order_is_seen_the_bar_is_the_largest_of_the_last_differences():
    positions = [0.0, 1.0, 2.0]
    assert bar([1.0, 1.2, 1.7], positions, 1.0).size == pytest.approx(0.5)
    assert bar([1.0, 1.2, 1.7], positions, 1.0).rate is None
    assert bar([1.0, 1.5, 1.1], positions, 1.0).size == pytest.approx(0.5)


def test_a_step_that_takes_little_off_hides_much():
    little = 0.2
    error = 0.5
    values = [1.0 + error * exp(little), 1.0 + error]
    assert bar(values, [0.0, little], None).size == pytest.approx(error)


def test_no_step_is_trusted_to_have_taken_off_more_than_it_is_known_to():
    """A step of 1e6 by theory may have left a part behind that it does not touch."""
    positions, values = [0.0, 3.0, 3.0 + np.log(1e6)], [1.0 + 0.1, 1.0 + 0.005, 1.0]
    size = bar(values, positions, 1.0, usual=Usual(0.005, own=True)).size
    assert size == pytest.approx(4 * 0.005 / 39)


def test_a_number_whose_error_is_known_in_its_parts_has_luck_of_its_own():
    """What it changed before tells no more of it than what its parts let expect."""
    positions, values = [0.0, 3.0, 6.0], [1.5, 1.0 + 1e-4, 1.0]
    of_window = bar(values, positions, 1.0, usual=Usual(1e-4)).size
    of_parts = bar(values, positions, 1.0, usual=Usual(1e-4, own=True)).size
    assert of_parts == pytest.approx(4e-4 / np.expm1(0.9 * 3.0))
    assert of_window > 10 * of_parts
    lucky = bar(values, positions, 1.0, usual=Usual(1e-2, own=True)).size
    assert lucky == pytest.approx(30 * of_parts)


def test_what_the_last_step_refined_nothing_of_stays_in_the_bar():
    """Its difference tells nothing of a part that it left as it was."""
    positions, values = [0.0, 3.0, 3.1], [1.0 + 1e-2, 1.0 + 1e-9, 1.0]
    step = Usual(1e-9, own=True)
    assert bar(values, positions, 1.0, usual=step).size < 1e-7
    assert bar(values, positions, 1.0, usual=replace(step, left=1e-4)).size == pytest.approx(1.2e-4)
    rises = [1.0, 1.0 + 1e-9, 1.0 + 1e-8]
    assert bar(rises, positions, 1.0, usual=replace(step, left=1e-4)).size == pytest.approx(1.2e-4)


def test_a_small_last_difference_alone_is_taken_for_luck():
    positions = [0.0, 1.0, 2.0]
    usual = bar([1.0, 1.1, 1.1 + 0.1 * exp(-1.0)], positions, 1.0).size
    lucky = bar([1.0, 1.1, 1.1 + 1e-9], positions, 1.0).size
    assert 0.1 * usual < lucky < usual
    assert bar([1.0, 1.0 + 1e-9], [0.0, 1.0], None, usual=Usual(0.02)).size == 0.02


@pytest.mark.parametrize("rate", [0.5, 0.8])
def test_where_others_show_how_errors_fall_two_numbers_do(rate):
    """Eight times the error that is left, never above the difference that is all they say alone."""
    step, error = log(50.0), 1e-3
    values = [1.0 + error * exp(rate * step), 1.0 + error]
    positions, parts = [0.0, step], Usual(0.0, own=True)
    alone = values[0] - values[1]
    assert bar(values, positions, None, usual=parts).size == pytest.approx(alone)
    by_others = bar(values, positions, rate, usual=parts).size
    assert by_others == pytest.approx(min(8 * error, alone))
    assert bar(values, positions, rate).size == pytest.approx(alone)  # nothing of it was measured
    assert bar(values, positions, 0.2, usual=parts).size == pytest.approx(alone)
    lucky = bar([1.0, 1.0], positions, rate, usual=Usual(alone, own=True)).size
    assert lucky == pytest.approx(min(0.3 * 8 * error, alone))
    left = bar([1.0, 1.0], positions, rate, usual=Usual(alone, own=True, left=error)).size
    assert left == pytest.approx(max(lucky, 1.2 * error))


def test_one_number_has_no_bar_and_equal_ones_that_of_rounding():
    assert bar([1.0], [0.0], 1.0).size == inf
    assert bar([1.0, 1.0, 1.0], [0.0, 1.0, 2.0], 1.0, rounding=1e-12).size == 1e-12


def test_typical_rate_is_a_median_of_what_is_seen():
    assert typical_rate([None, 0.5, 0.9, 40.0]) == pytest.approx(0.9)
    assert typical_rate([None]) is None


# What theory takes off


def test_theory_of_finer_elements_and_higher_degrees():
    old = Resolution(3, 1.0)
    assert reduction(old, Resolution(3, 2.0), 1e-4, singular=False) == pytest.approx(6 * np.log(2))
    raised = reduction(old, Resolution(4, 1.0), 1e-6, singular=False)
    assert raised == pytest.approx(-np.log(1e-6) / 3)
    singular = reduction(old, Resolution(3, 2.0), 1e-4, singular=True)
    assert singular == pytest.approx(1.4 * np.log(2))
    layered = fallen(old, Resolution(3, 1.0, 1), 1e-4)
    assert layered.smooth == 0
    assert layered.rough == pytest.approx(1.4 * np.log(5))


def test_the_rough_part_is_what_is_left():
    much = Fallen(20.0, 0.0).whole(singular=True)
    assert much == pytest.approx(np.log(10), rel=1e-6)
    assert Fallen(20.0, 0.0).whole(singular=False) == 20.0


def test_the_step_chosen_buys_most_per_second():
    found = [Step(Resolution(2, d), gain, s) for d, gain, s in ((1.2, 1.0, 1.0), (2.0, 3.0, 2.0))]
    assert chosen(found, 1e6, 10.0) is found[1]
    assert chosen(found, 1e6, 1.5) is found[0]
    assert chosen(found, 1.01, 10.0) is found[0]  # what is not needed counts for nothing
    assert chosen(found, 1e6, 0.5) is None
    assert cheapest(found, exp(2.0)) is found[1]
    assert cheapest(found, exp(4.0)) is None


def test_steps_end_at_the_highest_degree_and_refine_everything():
    made = list(steps("fe", Resolution(4, 1.0), Fallen(), 1e-3, 1.0, lambda _: 1.0, singular=False))
    assert {step.resolution.degree for step in made} == {4}
    assert all(step.resolution.density >= 1.25 for step in made)


# Modes followed and judged


def test_partners_are_pairs_of_growing_and_decaying_modes():
    values = np.array([2j, 1 + 3j, -1 + 3j, 0.5 + 4j])
    assert [pair.tolist() for pair in partners(values)] == [[1, 2]]


def test_pairs_that_flutter_on_one_mesh_are_one_cluster_on_all():
    apart, together = [1.00j, 1.01j], [-0.01 + 1.005j, 0.01 + 1.005j]
    found = clusters(sequence([apart, together]))
    assert [cluster.newest.tolist() for cluster in found] == [[0, 1]]
    assert not found[0].changed


def test_modes_that_are_lost_are_told():
    made = sequence([[1j, 2j, 3j], [1j, 2j, 3j]])
    made.links[0] = made.links[0][:2]
    assert lost(made, 2.5) == []
    assert lost(made, 3.5) == [3j]


def judged_members(rows, mu='"0.3*sin(pi*x/2)"'):
    """Members of a sequence of ``blocks``."""
    return judge(sequence(rows), load_scene("blocks", [f"contacts.interface.mu={mu}"])).members


def test_bars_of_single_modes_hold_their_errors():
    rows = np.array([converging(1j, 1e-2), converging(2j, 3e-2)]).T
    for member, exact in zip(judged_members(rows), (1.0, 2.0), strict=True):
        error = abs(member.value.imag - exact)
        assert error < member.frequency_bar < 6 * error
        assert member.verdict == "stable"
        assert member.growth_bar == 0


def pairs(splitting, error=1e-3, count=4):
    """Lambda of pairs whose mean and squared splitting of lambda^2 converge as theory says."""
    rows = []
    for i in range(count):
        taken = error * 16.0**-i
        root = np.sqrt(complex(splitting + 0.1 * taken))
        squares = -1.0 * (1 + taken) + np.array([root, -root])
        values = np.sqrt(squares)
        values = np.where(values.imag < 0, -values, values)
        rows.append(values[np.lexsort((values.real, values.imag))])
    return rows


@pytest.mark.parametrize(
    ("splitting", "verdicts"),
    [(1e-4, {"stable"}), (0.0, {"undecided"}), (-1e-4, {"stable", "unstable"})],
)
def test_the_sign_of_the_splitting_decides(splitting, verdicts):
    members = judged_members(pairs(splitting))
    assert {member.verdict for member in members} == verdicts
    for member in members:
        if member.verdict == "unstable":
            assert member.value.real > 0
            assert member.growth_bar < 0.1 * member.value.real
    if splitting == 0:
        reach = max(abs(member.value - 1j) for member in members)
        assert all(m.frequency_bar + m.growth_bar >= reach for m in members)


def test_without_friction_nothing_grows():
    assert {m.verdict for m in judged_members(pairs(0.0), mu="0.0")} == {"stable"}


def test_bars_that_overlap_are_judged_together():
    rows = [[1.00j, 1.30j], [1.10j, 1.20j], [1.10j, 1.14j]]
    judged = judge(sequence(rows), load_scene("blocks"))
    assert [len(cluster.newest) for cluster in judged.clusters] == [2]
    assert {member.verdict for member in judged.members} == {"undecided"}


def test_a_mode_that_changed_less_than_others_is_not_known_that_much_better():
    """As of the ring's axisymmetric one: an error of its own, that of curved cells, stays."""
    positions, values = [0.0, 0.9, 5.3], [1 + 1.6e-6, 1 + 1e-7, 1 - 1.5e-7]
    alone = bar(values, positions, 1.0)
    among = bar(values, positions, 1.0, usual=Usual(1.6e-4))
    assert alone.size < 1.5e-7 < among.size
    assert among.size == pytest.approx(4 * 0.3 * 1.6e-4 / 39)
    assert bar(values, positions, 1.0, usual=Usual(1e-8)).size == alone.size


def test_rigid_motions_are_known_to_their_rounding():
    rows = [[2e-15 + 0j, 1.1j], [1e-15j, 1.01j], [3e-15 + 0j, 1.001j]]
    rigid, moving = judge(sequence(rows), load_scene("blocks")).members
    assert rigid.rigid
    assert not moving.rigid
    assert rigid.frequency_bar == rigid.growth_bar == pytest.approx(1.3e-14)
    assert rigid.verdict == "rigid"
    assert shortfall(rigid, Request("blocks", digits=10), None) == 0.0


@pytest.mark.parametrize("rows", [[[1e-15j]], [[1e-3j], [1e-15j]], [[1e-15j], [1e-3j]]])
def test_what_one_mesh_alone_calls_rigid_has_no_such_bar(rows):
    (member,) = judge(sequence(rows), load_scene("blocks")).members
    assert not member.rigid
    assert shortfall(member, Request("blocks", digits=1), None) > 1


def test_of_one_mesh_no_mode_is_called_stable_where_there_is_friction():
    """Without a bar a mode may meet any other."""
    rows = [[1j, 2j]]
    rubbing = judge(sequence(rows), load_scene("blocks")).members
    assert [member.verdict for member in rubbing] == ["undecided"] * 2
    still = judge(sequence(rows), load_scene("blocks", ["contacts.interface.mu=0.0"])).members
    assert [member.verdict for member in still] == ["stable"] * 2


def test_digits_are_asked_of_growth_where_a_mode_grows():
    request = Request("blocks", digits=3)
    stable = Member(100j, 0.01, 0.0, "stable", 1.0, 3)
    assert shortfall(stable, request, None) == pytest.approx(0.2)
    grows = replace(stable, value=1 + 100j, growth_bar=0.02, verdict="unstable")
    assert shortfall(grows, request, None) == pytest.approx(0.02 / 0.005, rel=1e-3)


def test_backends_that_differ_beyond_their_bars_are_not_averaged():
    member = Member(100j, 0.01, 0.0, "stable", 1.0, 3)
    sequences = {"iga": sequence([[100j]])}
    judged = {"iga": Judged((member,), tuple(clusters(sequences["iga"])), Window())}
    (alone,) = combine(sequences, judged, inf)
    assert alone.agree is None
    from comparisons.converge.combined import _mode

    judged["fe"] = judged["iga"]
    far = {"iga": member, "fe": replace(member, value=101j)}
    apart = _mode(far, {"iga": 0, "fe": 0}, judged)
    assert apart.agree is False
    assert apart.member.value == 100j
    assert apart.member.frequency_bar == 1.0
    near = _mode(far | {"fe": replace(member, value=100.01j)}, {"iga": 0, "fe": 0}, judged)
    assert near.agree is True
