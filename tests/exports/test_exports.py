"""What other programs take of a joint, read back."""

import json
import re
import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.cli.command_results import _flow_remarks, summary
from jointclosure.exports import loading
from jointclosure.exports.geos import OPENING_SLOPE, geos_barton_bandis, geos_files
from jointclosure.exports.hyperbola import fitted_loading
from jointclosure.exports.joint_files import joint_files
from jointclosure.exports.porepy import porepy_files
from jointclosure.exports.udec_3dec import barton_bandis_commands, itasca_tables
from jointclosure.exports.vtu import fracture_mesh
from jointclosure.inputs.remarks import cautions, without_word
from jointclosure.joint import flow
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.history import history_of
from jointclosure.joint.laws import fitted_laws, law_curves, laws_of_joint, loading_hyperbolas
from jointclosure.joint.result_tables import (
    TRANSMISSIVITIES,
    WATER,
    curve_table,
    cycle_table,
    stress_table,
)
from jointclosure.plotting.joint import engineering_figure
from jointclosure.storage.folders import write
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.uncertainty import published_joints
from jointclosure.uncertainty.published_joints import measured_range
from jointclosure.uncertainty.ranges import MEANT
from tests.joints import COARSE, SPACING, closed, on_softer_half_spaces

UNKNOWN = ["at_least", "not_solved"]
"""Statuses of a flow of which only bounds are known."""
PLACE = "normal_stress_MPa"
_ENDS = "smallest_", "", "largest_"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What the command writes of a small joint."""
    folder = tmp_path_factory.mktemp("joint")
    words = ["--rock", "dolerite", "--cells", "24x20", "--stress", 5, "--tables", folder / "t"]
    words += ["--export-cycle", 2]
    words += ["--strength-bound", "none"]  # its second cycle takes several of the usual steps
    assert cli.main(["simulate", *map(str, words), "--output", str(folder / "joint.nc")]) == 0
    return folder


@pytest.fixture(scope="module")
def history(folder):
    return read_netcdf(folder / "joint.nc")


def porepy(history, cycle=2):
    return porepy_files(history, stress_table(history), cycle).files["porepy.json"]


def itasca(history):
    return itasca_tables(history, stress_table(history)).files["joint_stiffness.dat"]


def geos_table(history):
    files = geos_files(history, stress_table(history), 2).files
    return [np.array(files[f"geos_{name}.csv"].split(), float) for name in ("gap", "aperture")]


def itasca_table(text, name):
    """Stresses and values of a table."""
    (line,) = re.findall(rf"^table '{name}' add (.*)$", text, re.M)
    return np.array(re.findall(r"\(([^,]+),([^)]+)\)", line), dtype=float).T


def test_itasca_tables_hold_the_stiffness_in_si_units(folder):
    text = (folder / "t/joint_stiffness.dat").read_text()
    table = pd.read_csv(folder / "t/answer.csv").drop(columns="barton_bandis_mm").dropna()
    for (cycle, branch), own in table.groupby(["cycle", "branch"]):
        stress, values = itasca_table(text, f"kn-cycle-{cycle}-{branch}")
        np.testing.assert_allclose(stress, 1e6 * own.normal_stress_MPa, rtol=1e-6)
        np.testing.assert_allclose(values, 1e9 * own.normal_stiffness_net_MPa_per_mm, rtol=1e-6)
        assert (np.diff(stress) > 0.0).all()
        assert (np.diff(values) >= 0.0).all()


def with_flow(history, share=1.0, statuses=None):
    """A history whose hydraulic apertures are the mean one, and four times it, and bounds.

    Steps with a ``statuses`` word have it along x, and their aperture is not known.
    """
    aperture = history.mean_aperture.values
    along = np.stack([aperture, 4.0 * aperture], axis=1)
    own = xr.DataArray(along, {"direction": ["x", "y"]}, ("step", "direction"))
    status = xr.full_like(own, flow.STATUSES.index("flows" if share else "blocked"), dtype=np.int8)
    hydraulic = share * own
    for step, word in (statuses or {}).items():
        status[step, 0], hydraulic[step, 0] = flow.STATUSES.index(word), np.nan
    return history.assign(
        hydraulic_aperture=hydraulic,
        smallest_hydraulic=0.5 * share * own,
        largest_hydraulic=2.0 * own,
        flow_status=status.assign_attrs(flow.ATTRIBUTES["flow_status"]),
        flow_imbalance=xr.zeros_like(own),
    )


@pytest.mark.parametrize(("name", "factor"), [("aperture", 2.0), ("aperture-bound", 4.0)])
def test_tables_of_flow_hold_the_geometric_mean_of_both_directions(history, name, factor):
    flowing = with_flow(history)
    table = stress_table(flowing)
    first = table[(table.cycle == 1) & (table.branch == "loading")]
    _, values = itasca_table(itasca(flowing), f"{name}-cycle-1-loading")
    np.testing.assert_allclose(values, factor * 1e-3 * first.mean_aperture_mm, rtol=1e-6)


def test_flow_of_a_table_is_never_below_zero(history):
    flowing = with_flow(history)
    shut = flowing.hydraulic_aperture - flowing.hydraulic_aperture.min("step")  # at the maximum
    curves = stress_table(flowing.assign(hydraulic_aperture=shut))
    assert (curves[["hydraulic_aperture_mm", "transmissivity_m2_per_s"]] < 0.0).sum(axis=None) == 0


def test_the_transmissivity_of_a_bound_is_a_bound_by_its_name(history):
    table = stress_table(with_flow(history))
    for aperture, name in TRANSMISSIVITIES.items():
        exact = WATER * (1e-3 * table[aperture]) ** 3
        np.testing.assert_allclose(table[name], exact, rtol=1e-12)
    least, middle, most = (table[f"{end}transmissivity_m2_per_s"] for end in _ENDS)
    assert ((least < middle) & (middle < most)).all()


def test_a_bound_of_the_flow_never_stands_in_for_an_aperture_that_is_not_known(history):
    """Not solved at the maximum of the first cycle, bounded from below at that of the second."""
    tops = [int(history_of(history).branch(cycle, "unloading").steps[0]) for cycle in (1, 2)]
    flowing = with_flow(history, statuses=dict(zip(tops, ("not_solved", "at_least"), strict=True)))
    whole, table = stress_table(with_flow(history)), stress_table(flowing)
    names = ["hydraulic_aperture_mm", "transmissivity_m2_per_s"]
    for cycle, status in ((1, "not_solved"), (2, "at_least")):
        rows = table[table.cycle == cycle]
        unknown = rows.flow_status == status
        top = rows.normal_stress_MPa == rows.normal_stress_MPa.max()
        assert unknown[top].all()
        assert set(rows.flow_status[~unknown]) == {"flows"}
        assert rows.loc[unknown, names].isna().all(axis=None)
        # what is known is as it was, and both bounds are in columns of their own
        known = rows.index[~unknown]
        pd.testing.assert_frame_equal(rows.loc[known], whole.loc[known], rtol=0.05)
        for name in ("smallest_hydraulic_mm", "largest_hydraulic_mm"):
            np.testing.assert_allclose(rows[name], whole.loc[rows.index, name])
    steps = curve_table(flowing)
    assert steps.hydraulic_aperture_x_mm.isna().sum() == steps.flow_status_x.isin(UNKNOWN).sum() > 0
    assert (steps.flow_status_y == "flows").all()
    remarks = " ".join(_flow_remarks(flowing))
    for reason in ("the flow is not solved at 1 of", "the flow is known from below only at 1 of"):
        assert f"Warning: {reason}" in remarks
    text = itasca(flowing)
    assert "; aperture-cycle-1-loading: not known" in text
    assert itasca_table(text, "aperture-cycle-1-loading")[0].max() < 0.99 * 5e6
    files, remarks = geos_files(flowing, table, 2)
    assert "geos_aperture.csv" not in files
    assert "geos_aperture_bound.csv" in files["geos.xml"]
    assert "(flow_status: at_least)" in remarks[0]
    bound = np.array(files["geos_aperture_bound.csv"].split(), float)
    whole_files = geos_files(with_flow(history), whole, 2).files
    np.testing.assert_allclose(
        bound, np.array(whole_files["geos_aperture_bound.csv"].split(), float)
    )


def test_a_blocked_flow_gives_geos_a_bound_under_its_name_alone(history):
    blocked = with_flow(history, share=0.0)
    files = geos_files(blocked, stress_table(blocked), 2).files
    assert {name for name in files if "aperture" in name} == {"geos_aperture_bound.csv"}
    assert 'voxelFile="geos_aperture_bound.csv"' in files["geos.xml"]


@pytest.fixture(scope="module")
def shut_at_the_maximum(history):
    """A history whose flow is blocked along x at the maximum of cycle 1, and flows elsewhere."""
    top = int(history_of(history).branch(1, "unloading").steps[0])
    flowing = with_flow(history, statuses={top: "blocked"})
    for name in ("hydraulic_aperture", "smallest_hydraulic"):
        flowing[name][top, 0] = 0.0
    return flowing


def test_a_stress_beside_a_blocked_step_has_no_aperture(shut_at_the_maximum):
    table = stress_table(shut_at_the_maximum)
    shut = table.flow_status == "blocked"
    known = ["hydraulic_aperture_mm", "transmissivity_m2_per_s", "smallest_hydraulic_mm"]
    assert (table.loc[shut, PLACE] < 5.0).any()  # between the steps, not at the blocked one alone
    assert (table.loc[shut, known] == 0.0).all(axis=None)
    assert (table.loc[shut, "largest_hydraulic_mm"] > 0.0).all()
    flows = table[table.flow_status == "flows"]
    assert (flows[known] > 0.0).all(axis=None)


def test_stresses_without_an_aperture_are_named_on_the_screen(history, shut_at_the_maximum):
    laws = LAWS._replace(by_cycle={})
    table = stress_table(shut_at_the_maximum)
    loading = table[(table.cycle == 1) & (table.branch == "loading")]
    first = loading[PLACE][loading.flow_status == "blocked"].min()
    _, record = summary(shut_at_the_maximum, laws, table)
    (named,) = (line for line in record["remarks"] if "these stresses of answer.csv" in line)
    assert "the hydraulic aperture is 0, as the flow is blocked" in named
    stresses = named.partition("cycle 1, loading: ")[2].partition(";")[0]
    assert float(re.findall(r"[\d.]+", stresses)[0]) == first
    assert stresses.endswith("5")
    assert "cycle 2" not in named
    _, record = summary(with_flow(history), laws, stress_table(with_flow(history)))
    assert not any("these stresses of answer.csv" in line for line in record["remarks"])
    top = int(history_of(history).branch(2, "unloading").steps[0])
    bounded = with_flow(history, statuses={top: "at_least"})
    _, record = summary(bounded, laws, stress_table(bounded))
    (named,) = (line for line in record["remarks"] if "these stresses of answer.csv" in line)
    assert named.startswith("only bounds of the hydraulic aperture are known at these")
    assert "cycle 2, loading: " in named


def test_a_blocked_flow_has_no_point_on_a_logarithmic_axis(shut_at_the_maximum):
    first = shut_at_the_maximum.load_cycle == 1
    joint = shut_at_the_maximum.sel(step=first).sel(cycle=[1])
    _, _, aperture, axes = engineering_figure(joint, "a joint").axes
    assert axes.get_yscale() == "log"
    assert axes.get_xlim() == aperture.get_xlim()
    lines = [line for line in axes.lines if line.get_label().startswith("cycle 1")]
    drawn = np.concatenate([line.get_ydata() for line in lines])
    assert np.isnan(drawn).any()
    assert not (drawn == 0.0).any()


def test_apertures_for_geos_never_open_as_the_joint_closes(history):
    """Breakage may free a path: what GEOS reads is the smallest aperture up to that stress."""
    flow = with_flow(history)
    plain, rises = geos_table(flow)[1], flow.copy(deep=True)
    again = rises.load_cycle.values == 2
    factor = np.where(rises.normal_stress.values[again] > 3e6, 1.5, 1.0)
    rises["hydraulic_aperture"].values[again] *= factor[:, None]
    assert (np.diff(stress_table(rises).hydraulic_aperture_mm) > 0.0).any()
    held = geos_table(rises)[1]
    assert (np.diff(held) >= 0.0).all()
    assert held[-1] == plain[-1]
    assert held[0] > 1.02 * plain[0]


LOW, HIGH = 0.9, 1.3
BAND = {"": 1.0, "-low": LOW, "-high": HIGH}
"""Factors of curves and the ends of their band by the end of a name."""


def with_band(curves, low, high):
    """Curves of a table with the ends of a band."""
    names = [name for name in curves.select_dtypes("number") if name not in ("cycle", PLACE)]
    ends = {"low": low, "high": high}
    return curves.assign(**{f"{n}_{end}": f * curves[n] for n in names for end, f in ends.items()})


@pytest.fixture(scope="module")
def band(history):
    return with_band(stress_table(history), LOW, HIGH)


@pytest.mark.parametrize("ending", BAND)
def test_the_ends_of_a_band_have_itasca_tables_of_their_own(history, band, ending):
    text = itasca_tables(history, band).files["joint_stiffness.dat"]
    known = itasca_table(itasca(history), "kn-cycle-2-loading")[1]
    values = itasca_table(text, f"kn-cycle-2-loading{ending}")[1]
    np.testing.assert_allclose(values, BAND[ending] * known, rtol=1e-6)


CLOSES = {"": 1.0, "_closes_less": LOW, "_closes_more": HIGH}
"""Factors of the closure by endings of the constants that are fitted to it."""


@pytest.mark.parametrize("ending", CLOSES)
def test_joints_that_close_less_or_more_have_porepy_files_of_their_own(history, band, ending):
    files = porepy_files(history, band, 2).files
    assert set(files) == {f"porepy{end}.json" for end in CLOSES}
    stiffness, opening, residual, seating = files[f"porepy{ending}.json"].values()
    stiff, opens, stays, _ = porepy(history).values()
    assert seating == history_of(history).seating_stress > 0.0
    assert stiffness == pytest.approx(stiff / CLOSES[ending], rel=1e-3)
    assert opening == pytest.approx(CLOSES[ending] * opens, rel=1e-3)
    # all begin at the aperture of the joint at seating
    assert residual == pytest.approx(stays + opens - opening, rel=1e-6)


def test_the_residual_aperture_of_the_joint_lies_between_those_of_its_band(history, band):
    files = porepy_files(history, band, 2).files.values()
    joint, less, more = (solid["residual_aperture"] for solid in files)
    assert more < joint < less


def test_fish_names_joints_that_close_less_or_more(history, band):
    values, _ = fish_constants(history, band)
    for ending, factor in CLOSES.items():
        assert values[f"bb_vm{ending}"] == pytest.approx(factor * values["bb_vm"], rel=1e-3)
    text = barton_bandis_commands(history, band, LAWS, 2).files["barton_bandis.dat"]
    (line,) = re.findall(r"^\[global bb_kni_closes_less = .*$", text, re.M)
    assert line.endswith("a joint that closes less, an end of the band of closure")
    assert not re.search("_low|_high", text)


def test_constants_say_from_which_stress_their_hyperbola_is_fitted(history):
    text = barton_bandis_commands(history, stress_table(history), LAWS, 2).files
    about = "kni (Pa/m) of the hyperbola fitted from 0.5 MPa to cycle 2"
    assert about in text["barton_bandis.dat"]
    table = summary(history, LAWS, stress_table(history))[1]["table"]["cycle 2"]
    labels = "kni of the hyperbola fitted from 0.5 MPa (MPa/mm)", "Vm of the hyperbola fitted from"
    for label in labels:
        assert any(name.startswith(label) for name in table)


def test_an_end_of_the_band_without_constants_is_named_once(history, band):
    ends = ("low", "high")
    wide = {f"{n}_with_choices": band[n] for n in band if n.endswith(ends)}
    wide["closure_net_since_seating_mm_low_with_choices"] = np.nan
    unknown = band.assign(**wide)
    files, remarks = joint_files(history, unknown, LAWS, 2)
    (line,) = (remark for remark in remarks if "closes less, with other choices" in remark)
    assert line.startswith("PorePy, UDEC, 3DEC: not written: a joint")
    assert "porepy_closes_more_with_choices.json" in files
    assert "porepy_closes_less_with_choices.json" not in files


@pytest.fixture(scope="module")
def first_cycle(history):
    """The joint as it is after its first cycle."""
    return history.sel(step=history.load_cycle == 1).sel(cycle=[1])


def test_every_input_of_another_program_names_its_cycle(history):
    first, second = net_responses(history)["stiffness_net"]
    low, high = measured_range("stiffness_ratio")
    title = (
        f"cycle 2, which is {second / first:.3g} times as stiff as cycle 1 (chord stiffness), "
        f"while later loadings of measured joints were {low:.2g} to {high:.2g} times as stiff as "
        "the first"
    )
    laws = LAWS._replace(by_cycle={})
    files, remarks = joint_files(history, stress_table(history), laws, 2)
    for text in ("\n".join(remarks), files["barton_bandis.dat"]):
        assert f"of {title}" in text
    for name in ("geos.xml", "geos_barton_bandis.xml"):
        assert f"of the loading of {title}" in files[name]
        ElementTree.fromstring(files[name])  # whose comments have no two hyphens
    files, remarks = joint_files(history, stress_table(history), laws)
    stated = "\n".join(remarks)
    assert f"; --export-cycle 2 gives those of {title}" in stated
    for text in (stated, files["barton_bandis.dat"], files["geos.xml"]):
        assert "of cycle 1, the first loading" in text


def test_constants_are_of_the_first_loading_unless_another_cycle_is_named(history):
    laws = LAWS._replace(by_cycle={})
    files = joint_files(history, stress_table(history), laws).files
    kni, vm = loading_hyperbolas(history, [1]).loc[1]
    values = list(files["porepy.json"].values())[:2]
    assert values == pytest.approx([1e9 * kni, 1e-3 * vm])
    closes = -float(files["geos_gap.csv"].split()[0])
    curves = stress_table(history)
    first = curves[(curves.cycle == 1) & (curves.branch == "loading")]
    # seating lies between two steps, by a cubic here and by a chord there
    assert closes == pytest.approx(1e-3 * first.closure_net_since_seating_mm.max(), rel=1e-3)


@pytest.mark.parametrize(
    ("share", "title"),
    [(None, "mean aperture"), (1.0, "hydraulic aperture"),
     (0.0, "UPPER BOUND of the hydraulic aperture")],
)  # fmt: skip
def test_the_function_of_geos_says_which_aperture_it_has(history, share, title):
    joint = history if share is None else with_flow(history, share)
    files, remarks = geos_files(joint, stress_table(joint), 2)
    text = files["geos.xml"]
    assert f"Gap and {title} in m," in text
    warned = "geos.xml: its table, geos_aperture_bound.csv, is the upper bound of the hydraulic"
    assert any(warned in remark for remark in remarks) == (share == 0.0)


@pytest.mark.parametrize("status", ["flows", "not_solved"])
def test_the_aperture_of_porepy_is_compared_with_that_of_the_flow(history, status):
    """Here the hydraulic aperture is twice the mean one, the geometric mean of 1 and 4."""
    about = "PorePy: residual_aperture is of the mean aperture; the hydraulic aperture is"
    assert about not in " ".join(porepy_files(history, stress_table(history), 2).remarks)
    top = int(history_of(history).branch(2, "unloading").steps[0])
    flowing = with_flow(history, statuses={top: status} if status != "flows" else None)
    known = "2 times it" if status == "flows" else "not known"
    remarks = porepy_files(flowing, stress_table(flowing), 2).remarks
    assert f"{about} {known} at 5 MPa" in remarks


def test_the_ends_of_a_band_have_geos_tables_of_their_own(history, band):
    files = geos_files(history, band, 2).files
    apertures = [files[f"geos_aperture{end}.csv"].split() for end in ("_low", "", "_high")]
    assert (np.diff(np.array(apertures, float), axis=0) > 0.0).all()


def test_an_end_of_a_band_without_an_aperture_has_no_geos_table(history, band):
    full, remarks = geos_files(history, band.assign(mean_aperture_mm_low=0.0), 2)
    assert {"geos_aperture.csv", "geos_aperture_high.csv"} == {n for n in full if "aperture" in n}
    assert remarks[0].startswith("not written: geos_aperture_low.csv: the mean ap")


def test_named_stresses_change_no_input_of_other_programs_but_tables_for_dem(history):
    usual = stress_table(history)
    named = stress_table(history, history_of(history).table_levels([0.2e6, 1.3e6]))
    assert porepy_files(history, named, 2).files == porepy_files(history, usual, 2).files
    assert geos_files(history, named, 2).files == geos_files(history, usual, 2).files
    text = itasca_tables(history, named).files["joint_stiffness.dat"]
    assert {0.2e6, 1.3e6} <= set(itasca_table(text, "kn-cycle-2-loading")[0])


@pytest.fixture(scope="module")
def figure(history):
    """The engineering figure of a joint with flow, with a band."""
    flowing = with_flow(history)
    return engineering_figure(flowing, "a joint", with_band(stress_table(flowing), 0.9, 1.1))


def test_the_engineering_figure_names_its_bands(figure):
    (legend,) = figure.legends
    shown = {text.get_text() for text in legend.get_texts()}
    assert {"cycle 1, range", "cycle 2, range"} <= shown


def test_curves_of_all_cycles_have_one_neutral_entry_in_the_legend(figure):
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    entry = legend.legend_handles[texts.index("upper bound of the transmissivity")]
    assert entry.get_color() == "0.25"


def test_the_engineering_figure_shows_transmissivity_in_square_metres(figure):
    assert figure.axes[3].get_ylabel() == "transmissivity of water at 20 °C (m²/s)"


@pytest.fixture(scope="module")
def axes_with_law(history):
    """Axes of the engineering figure of a joint with a law of its first cycle."""
    law = SimpleNamespace(closure=lambda stress: 1e-3 * stress / (stress + 1e6))
    return engineering_figure(history, "a joint", laws={1: law}).axes


def test_laws_lie_inside_the_frame(axes_with_law):
    closing = axes_with_law[0]
    (drawn,) = (line for line in closing.lines if line.get_label() == "Barton-Bandis")
    assert drawn.get_xdata().max() > closing.lines[0].get_xdata().max()  # beyond the joint
    assert drawn.get_xdata().max() <= closing.get_xlim()[1]
    assert drawn.get_ydata().max() <= closing.get_ylim()[1]


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_no_cycle_hides_another_in_the_engineering_figure(axes_with_law, branch):
    for axes in axes_with_law[1:3]:
        widths = {
            line.get_label().removesuffix(" (same as loading)"): (
                line.get_linewidth(),
                line.get_zorder(),
            )
            for line in axes.lines
        }
        first, second = (widths[f"cycle {cycle}, {branch}"] for cycle in (1, 2))
        assert first[0] > 1.5 * second[0]  # it is seen beside the second, which is above it
        assert first[1] < second[1]


def test_porepy_closes_as_the_joint_does(folder, history):
    """Its fracture closes from the elastic opening by Bandis' hyperbola."""
    solid = json.loads((folder / "t/porepy.json").read_text())
    assert solid == porepy(history)
    stiffness, opening, residual, _ = solid.values()
    traction = float(history.normal_stress.max()) - 0.5e6
    closes = opening * traction / (stiffness * opening + traction)
    cycle = cycle_table(history).iloc[1]
    assert closes == pytest.approx(1e-3 * cycle.max_closure_seated_net_mm, rel=0.1)
    assert residual > 0.0
    # its aperture is that of the joint, under load too: both are of the net closure
    aperture = 1e-3 * cycle.mean_aperture_at_max_mm
    assert residual + opening - closes == pytest.approx(aperture, rel=0.01)
    fitted = 1e9 * loading_hyperbolas(history, [2]).loc[2, "kni_MPa_per_mm"]
    assert stiffness == pytest.approx(fitted, rel=1e-12)


def test_hyperbolas_that_are_drawn_are_those_of_the_screen(history):
    axes = engineering_figure(history, "joint", stress_table(history)).axes[0]
    (line,) = (drawn for drawn in axes.lines if drawn.get_label() == "hyperbolas fitted")
    closure, stress = line.get_data()
    kni, vm = loading_hyperbolas(history, [1]).loc[1]
    above = stress - 0.5
    np.testing.assert_allclose(closure, above * vm / (kni * vm + above), rtol=1e-12)


@pytest.fixture(scope="module")
def from_zero():
    """A joint without a seating stress, whose table begins above zero stress."""
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=1)
    return closed(walls, seating_stress=0.0, numerics=COARSE, cycles=1)


def test_without_a_seating_stress_constants_of_programs_agree_with_those_on_the_screen(from_zero):
    stiffness, opening, residual, _ = porepy(from_zero, 1).values()
    kni, vm = loading_hyperbolas(from_zero, [1]).loc[1]
    assert stiffness == pytest.approx(1e9 * kni, rel=1e-12)
    assert opening == pytest.approx(1e-3 * vm, rel=1e-12)
    at_first_touch = float(from_zero.mean_aperture[0])
    assert residual == pytest.approx(at_first_touch - opening, rel=1e-6)


def test_a_loading_that_closes_beyond_its_hyperbola_is_warned_of(from_zero):
    """It closes at once, and then in proportion to the stress."""
    laws = LAWS._replace(by_cycle={})
    stress = 1e-6 * from_zero.normal_stress
    closure = 1e-3 * (0.1 * (1.0 - np.exp(-20.0 * stress)) + 0.02 * stress)
    bent = from_zero.assign(closure=closure, bulk_indentation=0.0 * closure)
    largest = law_curves(bent)[1, "loading"][1].max()
    fitted = fitted_laws(bent, ["hyperbolic"], ["loading"]).iloc[1]
    assert fitted.value < largest
    text, record = summary(bent, laws, stress_table(bent))
    warned = [line for line in cautions(record["remarks"]) if "a hyperbola does not" in line]
    assert len(warned) == 1
    assert "describe the loading of cycle 1: " in warned[0]
    assert f"misses the closures by {1e3 * fitted.rms_mm:.2g} um rms" in warned[0]
    assert warned[0] in text
    assert "a hyperbola does not" not in summary(from_zero, laws, stress_table(from_zero))[0]


LAWS = laws_of_joint(9.0, 165e6, 0.5e6, 2, 1.0)


def fish_constants(history, curves, laws=LAWS, cycle=2):
    """Values of the FISH variables by name, and the function of the stiffness by bb_kni, bb_vm."""
    text = barton_bandis_commands(history, curves, laws, cycle).files["barton_bandis.dat"]
    values = {name: float(v) for name, v in re.findall(r"^\[global (\w+) = (\S+)\] ;", text, re.M)}
    (rule,) = re.findall(r"^    bb_stiffness = (.*)$", text, re.M) or ("",)
    known = values | {"kni": values.get("bb_kni"), "vm": values.get("bb_vm")}
    return values, lambda stress: eval(rule.replace("^", "**"), {}, known | {"stress": stress})


def test_constants_for_udec_or_3dec_are_those_of_the_laws(history):
    values, _ = fish_constants(history, stress_table(history))
    assert values["bb_lab_jrc"] == 9.0
    assert (values["bb_jrc"], values["bb_jcs"]) == pytest.approx(LAWS.scaled, rel=1e-6)
    assert (values["bb_lab_length"], values["bb_length"]) == (0.1, 1.0)
    for cycle in (1, 2):
        law = LAWS.from_zero(cycle)
        assert values[f"bb_empirical_kni_cycle_{cycle}"] == pytest.approx(
            law.initial_stiffness, rel=1e-6
        )
        assert values[f"bb_empirical_vm_cycle_{cycle}"] == pytest.approx(
            law.largest_closure, rel=1e-6
        )
    stiff, opening, *_ = porepy(history).values()
    assert (values["bb_kni"], values["bb_vm"]) == pytest.approx((stiff, opening), rel=1e-6)
    assert values["bb_empirical_aperture"] == pytest.approx(LAWS.from_zero(1).aperture, rel=1e-6)


@pytest.mark.parametrize(("cycle", "other"), [(1, 2), (2, 1)])
def test_constants_for_udec_or_3dec_have_those_of_the_other_cycles_too(history, cycle, other):
    values, _ = fish_constants(history, stress_table(history), cycle=cycle)
    for number, ending in ((cycle, ""), (other, f"_cycle_{other}")):
        kni, vm = loading_hyperbolas(history, [number]).loc[number]
        assert values[f"bb_kni{ending}"] == pytest.approx(1e9 * kni, rel=1e-6)
        assert values[f"bb_vm{ending}"] == pytest.approx(1e-3 * vm, rel=1e-6)
    assert f"bb_kni_cycle_{cycle}" not in values


def fitted_texts(joint, curves):
    """Texts of the files that have room for comments, by name."""
    files = itasca_tables(joint, curves).files
    files |= barton_bandis_commands(joint, curves, LAWS, 2).files
    for export in (geos_files, geos_barton_bandis):
        files |= export(joint, curves, 2).files
    return {name: text for name, text in files.items() if name.endswith((".dat", ".xml"))}


@pytest.mark.parametrize("measured", [(0.01, 0.02), (1.0, 1e9)])
def test_a_loading_whose_stiffness_is_beyond_measured_ones_is_warned_of(
    history, measured, monkeypatch
):
    for module in (loading, published_joints):
        monkeypatch.setattr(module, "measured_range", {"stiffness_ratio": measured}.get)
    curves = stress_table(history)
    beyond = measured[1] < 1.0
    remark = loading.loading_remark(history, 2)
    stiffness = net_responses(history)["stiffness_net"]
    assert f"{stiffness[1] / stiffness[0]:.3g} times as stiff as cycle 1" in remark
    assert cautions([remark]) == ([remark] if beyond else [])
    for text in [remark, *fitted_texts(history, curves).values()]:
        about = "later loadings of measured joints were 0.01 to 0.02 times as stiff as the first"
        assert (about in text) == beyond


def test_inputs_of_other_programs_have_the_ends_with_other_choices_of_the_model(history):
    choices = {"low": 0.9, "high": 1.1, "low_with_choices": 0.8, "high_with_choices": 1.3}
    names = [*("closure_net_since_seating_mm", "closure_gross_since_seating_mm")]
    names += ["normal_stiffness_net_MPa_per_mm", "normal_stiffness_gross_MPa_per_mm"]
    names += ["mean_aperture_mm"]
    curves = stress_table(history)
    ends = {f"{name}_{end}": f * curves[name] for name in names for end, f in choices.items()}
    wide = curves.assign(**ends)
    files = porepy_files(history, wide, 2).files
    values, _ = fish_constants(history, wide)
    vm = "maximum_elastic_fracture_opening"
    for end, factor in {"closes_less": 0.8, "closes_more": 1.3}.items():
        largest = files[f"porepy_{end}_with_choices.json"][vm]
        assert largest == pytest.approx(factor * files["porepy.json"][vm], rel=0.02)
        assert values[f"bb_vm_{end}_with_choices"] == pytest.approx(largest, rel=1e-6)
    text = itasca_table(
        itasca_tables(history, wide).files["joint_stiffness.dat"],
        "kn-cycle-2-loading-high-with-choices",
    )
    usual = itasca_table(itasca(history), "kn-cycle-2-loading")
    np.testing.assert_allclose(text[1], 1.3 * usual[1], rtol=1e-5)
    assert "geos_aperture_low_with_choices.csv" in geos_files(history, wide, 2).files
    law = geos_barton_bandis(history, wide, 2).files["geos_barton_bandis.xml"]
    assert 'name="joint_aperture_high_with_choices"' in law
    for text in fitted_texts(history, wide).values():
        assert f"of the ends of the range, which is {MEANT}" in text
        assert "of the ends of the range with other choices of the model too" in text


def test_the_stiffness_for_udec_or_3dec_is_the_slope_of_the_hyperbola(history):
    _, stiffness = fish_constants(history, stress_table(history))
    stiff, opening, *_ = porepy(history).values()
    assert stiffness(0.5e6) == pytest.approx(stiff, rel=1e-6)
    # the slope of the stress over the closure of the hyperbola
    stress = np.array([2e6, 2.001e6])
    closure = (stress - 0.5e6) * opening / (stiff * opening + stress - 0.5e6)
    assert stiffness(2.0005e6) == pytest.approx(1e3 / np.diff(closure)[0], rel=1e-4)


def test_fish_says_how_far_the_stiffness_of_the_hyperbola_is_from_that_of_the_joint(history):
    curves = stress_table(history)
    text = barton_bandis_commands(history, curves, LAWS, 2).files["barton_bandis.dat"]
    (low, high) = re.findall(r"; the stiffness .* by (.*) % to (.*) % at", text)[0]
    values, stiffness = fish_constants(history, curves)
    rows = curves[(curves.cycle == curves.cycle.max()) & (curves.branch == "loading")]
    rows = rows[1e6 * rows.normal_stress_MPa > values["bb_seating"]]
    known = 1e9 * rows.normal_stiffness_net_MPa_per_mm
    apart = [
        100.0 * (stiffness(1e6 * stress) / own - 1.0)
        for stress, own in zip(rows.normal_stress_MPa, known, strict=True)
    ]
    assert (float(low), float(high)) == pytest.approx((min(apart), max(apart)), rel=0.1)


def test_the_misfit_of_the_hyperbola_is_stated_once_for_porepy_too(history):
    files, remarks = joint_files(history, stress_table(history), LAWS, 2)
    (stated,) = (line for line in remarks if "the stiffness of the fitted hyperbola" in line)
    assert without_word(stated).startswith("PorePy, UDEC, 3DEC, of cycle 2: ")
    misfit = stated.partition("hyperbola ")[2].partition("; its closures")[0]
    assert misfit in files["barton_bandis.dat"]


@pytest.mark.parametrize(("stiffer", "warned"), [(1.4, False), (1.6, True)])
def test_a_hyperbola_whose_stiffness_is_far_from_that_of_the_joint_is_warned_of(
    history, stiffer, warned
):
    """With a factor, the stiffness of the joint is that of its own hyperbola times a number."""
    table = stress_table(history)
    law = fitted_loading(history, table, 2).hyperbolas[""]
    above = 1e6 * table.normal_stress_MPa - history_of(history).seating_stress
    kn = law.stiffness * (1.0 + above / (law.stiffness * law.largest_closure)) ** 2
    own = table.assign(normal_stiffness_net_MPa_per_mm=1e-9 * kn / stiffer)
    (stated,) = (n for n in fitted_loading(history, own, 2).remarks if "fitted hyperbola" in n)
    assert bool(cautions([stated])) == warned


@pytest.fixture(scope="module")
def straight(history):
    """A joint that closes in proportion to the stress, which is no hyperbola."""
    closure = 1e-12 * history.normal_stress
    return history.assign(closure=closure, bulk_indentation=0.0 * closure)


def test_the_law_for_udec_or_3dec_is_there_without_a_hyperbola_of_the_joint(straight):
    values, _ = fish_constants(straight, stress_table(straight))
    reason = "constants of the simulated joint: UDEC, 3DEC: the loading of cycle 2 hardly bends"
    curves = stress_table(straight)
    (remark,) = barton_bandis_commands(straight, curves, LAWS, 2).remarks
    assert remark.startswith(f"not written: {reason}")
    assert "bb_kni" not in values
    assert "bb_empirical_kni_cycle_1" in values


def test_udec_or_3dec_get_nothing_without_a_hyperbola_or_a_law(straight):
    with pytest.raises(jc.InputError, match="UDEC, 3DEC: the loading of cycle 2 hardly bends"):
        fish_constants(straight, stress_table(straight), laws_of_joint(2.0, 165e6, 0.5e6, 2))


@pytest.mark.parametrize("flowing", [False, True])
def test_bartonbandis_of_geos_gives_the_apertures_back(history, flowing):
    """By its formula in BartonBandis.hpp, a0/(1 + 9 s/s_ref)."""
    history = with_flow(history) if flowing else history
    curves = stress_table(history)
    text = geos_barton_bandis(history, curves, 2).files["geos_barton_bandis.xml"]
    law = ElementTree.fromstring(text).find("BartonBandis")
    start, reference = (float(law.get(f"reference{w}")) for w in ("Aperture", "NormalStress"))
    rows = curves[(curves.cycle == 2) & (curves.branch == "loading")]
    read = start / (1.0 + 9.0 * 1e6 * rows.normal_stress_MPa / reference)
    known = 1e-3 * rows["hydraulic_aperture_mm" if flowing else "mean_aperture_mm"]
    (off,) = re.findall(r"off by up to (\S+) um", text)
    assert np.abs(read - known).max() == pytest.approx(1e-6 * float(off), rel=0.1)
    exact = curves.assign(mean_aperture_mm=0.2 / (1.0 + 9.0 * curves.normal_stress_MPa / 50.0))
    if not flowing:
        text = geos_barton_bandis(history, exact, 2).files["geos_barton_bandis.xml"]
        assert 'referenceAperture="2.000000e-04" referenceNormalStress="5.000000e+07"' in text
    opens = curves.assign(
        mean_aperture_mm=curves.normal_stress_MPa, hydraulic_aperture_mm=curves.normal_stress_MPa
    )
    with pytest.raises(jc.InputError, match="aperture must be known, and fall with stress"):
        geos_barton_bandis(history, opens, 2)


def test_programs_that_deform_the_rock_themselves_get_nothing_of_it(history):
    """Softer half-spaces change no number of theirs: what they take is net."""
    history = history.assign_attrs(numerics="{}")  # no landing, whose steps are gross
    softer = on_softer_half_spaces(history)
    assert porepy(softer) == pytest.approx(porepy(history), rel=1e-4)
    np.testing.assert_allclose(geos_table(softer), geos_table(history), rtol=1e-6, atol=1e-12)
    tables = [re.findall(r"[\d.]+e[+-]\d+", itasca(each)) for each in (history, softer)]
    np.testing.assert_allclose(*(np.array(table, float) for table in tables), rtol=1e-6)


def test_geos_takes_the_table(folder, history):
    """What its validateApertureTable asks for: the last coordinate 0, the last slope below 1."""
    function = ElementTree.parse(folder / "t/geos.xml").getroot()
    assert function.tag == "TableFunction"
    gap = np.loadtxt(folder / "t" / function.get("coordinateFiles").strip("{ }"))
    aperture = np.loadtxt(folder / "t" / function.get("voxelFile"))
    assert gap[-1] == 0.0
    assert (np.diff([gap, aperture]) > 0.0).all()
    assert (aperture[-1] - aperture[-2]) / (gap[-1] - gap[-2]) < 1.0
    # seating lies between two steps, by a cubic here and by a chord there
    cycle = cycle_table(history).iloc[1]
    assert -gap[0] == pytest.approx(1e-3 * cycle.max_closure_seated_net_mm, rel=0.1)
    # as each wall keeps its volume, the mean aperture falls by the net closure less the overlap
    here = (history.load_cycle == 2) & (history.branch == "loading")
    overlap = float(history.mean_overlap[here].max())
    distance = aperture[0] - gap[0] - aperture[-1]
    assert 0.5 * overlap < distance < 1.01 * overlap
    second = history.mean_aperture.values[history.load_cycle.values == 2]
    assert aperture[0] == pytest.approx(second.min(), rel=1e-4)  # at the stated maximum


def mesh_of(upper, lower):
    """Return points, triangles and fields of the mesh of a joint that ends with these walls."""
    axes = {name: SPACING * np.arange(n) for name, n in zip("yx", upper.shape, strict=True)}
    walls = {"upper_final": (("y", "x"), upper), "lower_final": (("y", "x"), lower)}
    (mesh,) = fracture_mesh(xr.Dataset(walls, axes)).files.values()
    return mesh


def test_the_mesh_is_the_midplane_with_its_aperture(small_joint, tmp_path):
    meshio = pytest.importorskip("meshio")
    upper, lower = small_joint
    write(mesh_of(upper, lower), tmp_path / "a.vtu")
    read = meshio.read(tmp_path / "a.vtu")
    ny, nx = upper.shape
    triangles = read.cells_dict["triangle"]
    assert triangles.shape == (2 * (ny - 1) * (nx - 1), 3)
    corners = read.points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (across[:, 2] > 0.0).all()  # all face up, and cover the joint once
    assert 0.5 * across[:, 2].sum() == pytest.approx((ny - 1) * (nx - 1) * SPACING**2)
    gap = (upper + lower).max() - upper - lower
    np.testing.assert_allclose(read.points[:, 2], (lower + 0.5 * gap).ravel())
    aperture = read.cell_data_dict["aperture"]["triangle"]
    np.testing.assert_allclose(aperture, gap.ravel()[triangles].mean(axis=1), atol=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_the_triangles_of_the_mesh_in_contact_are_those_beside_the_cell_of_first_touch(seed):
    """The rounding of a difference of three heights may leave a gap there."""
    upper, lower = jc.wall_pair(8.0, (10, 12), SPACING, seed=seed)
    _, triangles, fields = mesh_of(upper, lower)
    touch = np.argmax(upper + lower)
    np.testing.assert_array_equal(fields["contact"], (triangles == touch).any(axis=1))


def test_a_loading_that_begins_above_seating_has_no_constants():
    walls = jc.wall_pair(8.0, (24, 20), SPACING, seed=1)
    joint = closed(walls, [4e6, 0.0, 4e6, 1e6, 4e6], seating_stress=0.5e6)
    assert len(porepy(joint, 2)) == 4
    reason = "the loading of cycle 3 does not begin at or below the seating stress, 500000 Pa"
    with pytest.raises(jc.InputError, match=f"PorePy: {reason}"):
        porepy(joint, 3)


@pytest.fixture(scope="module")
def without_interaction():
    """A joint in which only cells in contact do not close."""
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)
    alone = jc.Effects(interaction=False, breakage=False, gouge=False)
    return closed(walls, 2e6, effects=alone, seating_stress=0.2e6)


def test_an_end_of_a_band_at_zero_is_not_said_to_flow(history, band):
    """Its simulations may all flow, as changes by choices of the model are extrapolated."""
    flowing = with_flow(history)
    curves = with_band(stress_table(flowing), 0.9, 1.1).assign(range_flow_status="flows")
    ends = {"low": 0.0, "high": 2.0}
    for name in ("hydraulic_aperture_mm", "largest_hydraulic_mm"):
        for end, factor in ends.items():
            curves[f"{name}_{end}"] = factor * curves[name]
    reasons = [line for line in geos_files(flowing, curves, 2).remarks if "aperture_low" in line]
    (reason,) = reasons
    assert "the hydraulic aperture, low end of its band, is 0 at " in reason
    assert "flows" not in reason


@pytest.mark.parametrize(("error", "warned"), [(0.0, False), (-0.8, True)])
def test_a_law_of_geos_that_misses_the_aperture_by_half_is_a_warning(history, error, warned):
    curves = stress_table(history)
    stress = curves.normal_stress_MPa
    law = 0.2 / (1.0 + 9.0 * stress / 50.0)
    bent = curves.assign(mean_aperture_mm=law * (1.0 + error * (stress == stress.max())))
    (remark, *_) = geos_barton_bandis(history, bent, 2).remarks
    assert (remark in cautions([remark])) == warned


def test_only_the_end_of_a_table_that_is_too_steep_for_geos_is_changed(without_interaction):
    gap, aperture = geos_table(without_interaction)
    slopes = np.diff(aperture) / np.diff(gap)
    assert slopes[-1] == pytest.approx(OPENING_SLOPE, rel=1e-6)
    np.testing.assert_allclose(slopes[:-1], 1.0, rtol=1e-2)
    assert (slopes < 1.0).all()
    assert gap[-1] == 0.0


def test_a_mean_aperture_of_zero_is_refused_for_geos(without_interaction):
    blocked = without_interaction.assign(mean_aperture=0.0 * without_interaction.mean_aperture)
    refused = r"mean aperture is 0 at 0.2 MPa, and GEOS needs a positive one at every stress"
    with pytest.raises(jc.InputError, match=refused):
        geos_table(blocked)
