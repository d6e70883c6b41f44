"""Profiles, which are heights along a line: how they are read and what is measured of them."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.cli.main import main
from jointclosure.inputs.remarks import cautions
from jointclosure.storage.files import read_csv
from jointclosure.walls.jrc import RELATIONS, z2_of_jrc
from jointclosure.walls.profile_roughness import (
    Profile,
    levelled_profile,
    measure_profile,
    read_profile,
)
from jointclosure.walls.wall_roughness import jrc_of_relation, slope_over_interval

SPACING, HURST = 0.25e-3, 0.8


def made(slope, count=400, seed=1, spacing=SPACING):
    """A self-affine profile (count,) [m] with an RMS slope at its spacing."""
    random = np.random.default_rng(seed)
    frequencies = np.fft.rfftfreq(8 * count)
    frequencies[0] = np.inf
    waves = np.fft.rfft(random.standard_normal(8 * count)) * frequencies ** -(HURST + 0.5)
    heights, line = np.fft.irfft(waves, 8 * count)[:count], np.arange(count)
    heights -= np.polyval(np.polyfit(line, heights, 1), line)
    return heights * slope * spacing / np.sqrt(np.mean(np.diff(heights) ** 2))


def measured(heights, places=None):
    places = SPACING * np.arange(heights.size) if places is None else places
    return {m.name: m for m in measure_profile(*levelled_profile(Profile(places, heights))[:2])}


def written(folder, lines, name="profile.csv"):
    file = folder / name
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


@pytest.mark.parametrize("name", RELATIONS)
def test_each_relation_gives_the_jrc_that_a_profile_was_made_with(name):
    slope = z2_of_jrc(9.0, SPACING, HURST, name)
    jrcs = [measured(made(slope, 1000, seed))[f"JRC, {name}"].value for seed in range(3)]
    assert np.mean(jrcs) == pytest.approx(9.0, abs=0.5)


def test_stigsson_and_mas_ivars_have_their_height_differences_over_a_millimetre():
    places = SPACING * np.arange(2000)
    heights = levelled_profile(Profile(places, made(0.25, 2000)))[0]
    found = measured(heights)
    over_1mm = 1e3 * np.sqrt(np.mean((heights[4:] - heights[:-4]) ** 2))
    expected = -4.3 + 54.6 * over_1mm + 4.3 * found["H"].value
    assert found["JRC, stigsson_mas_ivars"].value == pytest.approx(expected, abs=0.05)


def test_a_zigzag_has_its_exact_measures():
    heights = 0.1e-3 * np.abs(np.arange(301) % 14 - 7)
    found = measured(heights)
    assert found["Z2"].value == pytest.approx(0.4, rel=1e-3)
    assert found["Rp, length over that of the line"].value == pytest.approx(
        np.hypot(1, 0.4), rel=1e-3
    )


def test_values_lie_within_their_intervals():
    assert all(m.low < m.value < m.high for m in measured(made(0.25)).values())


def test_intervals_of_short_profiles_contain_the_slope_of_all():
    heights = made(0.25, 64 * 30)
    found = [measured(part)["Z2"] for part in heights.reshape(30, 64)]
    truth = np.sqrt(np.mean([m.value**2 for m in found]))  # of level parts
    assert np.mean([m.low <= truth <= m.high for m in found]) > 0.85


@pytest.mark.parametrize("degrees", [-4.0, 3.0, 12.0])
def test_an_inclined_profile_has_the_jrc_of_the_level_one(degrees):
    x, z = SPACING * np.arange(400), made(0.2)
    angle = np.radians(degrees)
    places, heights = x * np.cos(angle) - z * np.sin(angle), x * np.sin(angle) + z * np.cos(angle)
    level, inclined = measured(z), measured(heights, places)
    name = "JRC, yu_vayssade_linear_0.25mm"
    assert inclined[name].value == pytest.approx(level[name].value, rel=0.08)


def test_uneven_points_have_nearly_the_slope_of_the_even_ones():
    heights, random = made(0.2, 1200), np.random.default_rng(4)
    keep = np.sort(random.choice(1200, 700, replace=False))
    places = SPACING * np.arange(1200)
    found = measured(heights[keep], places[keep])
    assert found["H"].value == pytest.approx(HURST, abs=0.15)
    assert found["Z2"].value == pytest.approx(0.2, rel=0.15)


@pytest.fixture(scope="module")
def with_a_gap():
    """A levelled profile that lacks twenty places, after which it is higher, and its spacing."""
    places, heights = SPACING * np.arange(200), made(0.2, 200)
    heights[120:] += 1e-3  # across the gap, where it must not count as a slope
    kept = np.r_[0:100, 120:200]
    kept = kept[kept != 150]  # a step of two spacings is no gap
    level, spacing, _ = levelled_profile(Profile(places[kept], heights[kept]))
    return level, spacing


def test_a_gap_has_no_heights(with_a_gap):
    level, spacing = with_a_gap
    assert spacing == pytest.approx(SPACING)
    assert np.isnan(level).sum() == 20


def test_a_gap_is_not_bridged(with_a_gap):
    assert measure_profile(*with_a_gap)[1].value < 0.3


@pytest.mark.parametrize(
    ("lines", "units"),
    [
        (["x (mm),z (mm)", "{x:.4f},{z:.6f}"], None),
        (["distance (mm);height (um)", "{x:.4f};{um:.3f}"], None),
        (["{x:.4f} {z:.6f}"], "mm"),
        (["z_mm,x_mm", "{z:.6f},{x:.4f}"], None),
        (["x_mm,y_mm", "{x:.4f},{z:.6f}"], None),
        (["number,x_mm,z_mm", "7,{x:.4f},{z:.6f}"], None),
    ],
)
def test_a_profile_is_read_as_people_write_it(tmp_path, lines, units):
    x, z = 1e3 * SPACING * np.arange(60), 1e3 * made(0.2, 60)
    *head, line = lines
    rows = [line.format(x=a, z=b, um=1e3 * b) for a, b in zip(x, z, strict=True)]
    profile = read_profile(written(tmp_path, [*head, *rows]), units=units)
    np.testing.assert_allclose(profile.places, 1e-3 * x, atol=1e-12)
    np.testing.assert_allclose(profile.heights, 1e-3 * z, atol=1e-8)


def test_a_profile_read_backwards_has_the_same_measures(tmp_path):
    x, z = 1e3 * SPACING * np.arange(60), 1e3 * made(0.2, 60)
    rows = [f"{a:.4f} {b:.6f}" for a, b in zip(x[::-1], z[::-1], strict=True)]
    profile = read_profile(written(tmp_path, rows), units="mm")
    assert (np.diff(profile.places) > 0.0).all()
    expected = measured(1e-3 * z)["Z2"].value
    assert measured(profile.heights)["Z2"].value == pytest.approx(expected, rel=1e-3)


def test_missing_heights_are_left_out_with_a_warning(tmp_path):
    rows = [f"{0.25 * n:.2f} {'nan' if n == 30 else 0.1 * (n % 3)}" for n in range(60)]
    profile = read_profile(written(tmp_path, rows), units="mm")
    assert profile.heights.size == 59
    assert cautions(profile.remarks) == ["Warning: 1 points without a height were left out"]


@pytest.mark.parametrize(
    ("lines", "given", "message"),
    [
        (["0 1", "1 2", "2 1"], {}, "does not state the units"),
        (["x_um,z_um", "0,1", "1,2"], {"units": "mm"}, "units = 'mm': the distances of the file"),
        (["0 1", "1 2", "0.5 1", "2 1"], {"units": "mm"}, "point 3 is not beyond"),
        (["0 1 2", "1 2 3"], {"units": "mm"}, "3 columns .* must be two, or named x and z"),
        (["0 1 2", "1 2 3"], {"units": "mm", "variable": "1,4"}, "variable = '1,4'"),
        (["x,y,z", "0,1,2", "1,2,3"], {"units": "mm"}, r"3 columns \(x, y, z\)"),
    ],
)
def test_a_file_that_is_no_profile_is_refused_with_its_name(tmp_path, lines, given, message):
    file = written(tmp_path, lines)
    with pytest.raises(jc.InputError, match=message) as caught:
        read_profile(file, **given)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize(
    ("heights", "message"),
    [(np.zeros(50), "all heights are equal"), (made(0.2, 20), "20 points: must be at least 24")],
)
def test_a_profile_without_roughness_or_too_short_is_refused(heights, message):
    with pytest.raises(jc.InputError, match=message):
        measured(heights)


@pytest.fixture
def by_command(tmp_path, capsys):
    """What the command prints of a profile, its table, and its picture."""
    rows = [f"{0.25 * n:.2f} {1e3 * z:.6f}" for n, z in enumerate(made(0.25))]
    file, table = written(tmp_path, rows), tmp_path / "measures.csv"
    picture = tmp_path / "profile.png"
    words = ["roughness", str(file), "--profile", "--units", "mm"]
    assert main([*words, "--table", str(table), "--picture", str(picture)]) == 0
    return capsys.readouterr().out, table, picture


def test_the_command_measures_a_profile(by_command):
    out, table, picture = by_command
    assert "400 places 0.25 mm apart; mean line removed" in out
    assert set(read_csv(table).measure) >= {f"JRC, {name}" for name in RELATIONS}
    assert picture.stat().st_size > 0


def test_relations_are_printed_with_their_sources_and_the_default_is_named(by_command):
    out, _, _ = by_command
    assert all(relation.title in out for relation in RELATIONS.values())
    assert "that of Yu & Vayssade 1991, linear, 0.25 mm is the default of close" in out
    assert not any(name in out for name in RELATIONS)


@pytest.mark.parametrize("words", [["--spacing", "0.5"], ["--missing", "linear"]])
def test_options_of_walls_are_refused_with_a_profile(tmp_path, capsys, words):
    file = written(tmp_path, ["0 0", "1 1"])
    assert main(["roughness", str(file), "--profile", *words]) == 2
    assert f"{words[0]}: must be left out with --profile" in capsys.readouterr().err


def test_z2_between_two_measured_distances_lies_between_its_values_there():
    scatter = {"Z2 at 2": np.array([0.178]), "Z2 at 3": np.array([0.170])}
    slope, how = slope_over_interval(1e-3, scatter, np.array([0.196]), 0.4e-3, 1.223)
    assert 0.170 < slope[0] < 0.178
    assert "between those at 0.8 and 1.2 mm" in how
    measures = {m.name: m for m in measure_profile(made(0.2, 200), 0.4e-3)}
    assert "between those at 0.8 and 1.2 mm" in measures["JRC, tatone_grasselli_1mm"].remark


@pytest.mark.parametrize("interval", [0.25e-3, 1e-3])
def test_no_slope_is_carried_by_a_hurst_exponent_above_1(interval):
    slope, how = slope_over_interval(interval, {}, np.array([0.2]), 0.4e-3, np.array([1.223]))
    assert slope[0] == 0.2
    assert how.endswith("by H = 1")


def test_an_interval_of_jrc_that_ends_outside_of_its_relation_is_named():
    relation = RELATIONS["tatone_grasselli_1mm"]
    inside, outside = (np.array([0.2, 0.15, end]) for end in (0.25, 0.5))
    assert "OUTSIDE" not in jrc_of_relation(relation, inside, "")[1]
    assert jrc_of_relation(relation, outside, "")[1].endswith("the interval ends OUTSIDE")


def test_a_hurst_exponent_above_1_is_warned_of(tmp_path, capsys):
    x = 0.4 * np.arange(100)
    rows = [f"{a:.4f},{b:.6f}" for a, b in zip(x, np.sin(x / 8.0), strict=True)]
    file = written(tmp_path, ["x_mm,z_mm", *rows])
    assert main(["roughness", str(file), "--profile"]) == 0
    assert "Warning: H is 1." in capsys.readouterr().out
