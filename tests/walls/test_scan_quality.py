"""Rounding, short waves and noise of a scan are those that were put into it, and measured once."""

import re
from collections import Counter

import numpy as np
import pytest
import scipy

import jointclosure as jc
from benchmarks.registration import rotation
from benchmarks.scan_defects import ended
from jointclosure.walls import rounding, scan_defects, scan_quality
from jointclosure.walls.gridding import Cloud, Scan, point_distance, points_of
from jointclosure.walls.jrc import rms_slope
from jointclosure.walls.registration import registered
from jointclosure.walls.rounding import rounding_of
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_errors import noise_of
from jointclosure.walls.scan_noise import noise_of_points
from jointclosure.walls.scan_quality import quality_of, quality_remarks
from jointclosure.walls.spectrum_end import spectrum_end
from tests.joints import SPACING
from tests.walls.sampled import noisy, sampled_walls, scan_of


@pytest.fixture(scope="module")
def walls():
    return sampled_walls()


def remarks_on(wall):
    """Cautions about heights (y, x) [m] as a scan."""
    return quality_remarks(quality_of(scan_of(wall)), wall, SPACING)


MEASURES = {
    "grids": {"rounding_of": 2, "shortest_wave": 2, "spectrum_end": 2, "noise_of_grid": 2},
    "points": {"rounding_of": 2, "noise_of_points": 2},
    "a grid on a flat wall": {"rounding_of": 1, "shortest_wave": 1, "spectrum_end": 1,
                              "noise_of_grid": 1},
}  # fmt: skip


@pytest.mark.parametrize("scans", MEASURES)
def test_the_quality_of_a_scan_is_measured_once(scans, walls, monkeypatch):
    """In a whole registration; heights are sorted once more by the inspection of a grid."""
    counts = Counter()

    def counted(module, name):
        measure = getattr(module, name)

        def counting(*given):
            counts[name] += 1
            return measure(*given)

        monkeypatch.setattr(module, name, counting)

    names = ("rounding_of", "shortest_wave", "spectrum_end", "noise_of_grid", "noise_of_points")
    for name in names:
        counted(scan_quality, name)
    for module in (rounding, scan_defects, scan_quality):
        counted(module, "step_of")
    upper, lower = scan_of(1e-3 - walls[0]), scan_of(walls[1])
    if scans == "points":
        upper, lower = Cloud(points_of(upper)), Cloud(points_of(lower))
    elif scans != "grids":
        upper = "flat"
    stated = {"orientation": "common_frame", "shift": "scanned"} if upper != "flat" else {}
    registered(upper, lower, **stated)
    sorts = {"grids": 4, "points": 6}.get(scans, 2)  # of a cloud also x and y
    assert counts == MEASURES[scans] | {"step_of": sorts}


@pytest.mark.parametrize("finer", [1, 2])
@pytest.mark.parametrize("roll_off", [None, 3e-3])
@pytest.mark.parametrize("noise", [0.0, 5.7e-6, 18e-6])
def test_the_noise_of_a_scanner_is_that_which_was_added(noise, roll_off, finer):
    """To walls with and without waves that are shorter than the grid. The interval of 95 % contains
    it in at least 9 of 12 scans: 8 or fewer have a probability of 0.002.
    """
    held = 0
    for seed in range(12):
        hurst, jrc = 0.5 + 0.04 * (seed % 11), 5.0 + 0.8 * seed
        shape = (96 * finer, 80 * finer)
        wall, _ = jc.wall_pair(jrc, shape, SPACING / finer, seed, hurst, roll_off=roll_off,
                               unusual_values=True)  # fmt: skip
        random = np.random.default_rng(seed)
        heights = wall[::finer, ::finer] + noise * random.standard_normal((96, 80))
        low, high = quality_of(scan_of(heights)).noise
        held += low <= noise <= high
    assert held >= 9


def test_roughness_below_the_grid_is_no_noise_of_the_scanner():
    """It is as high as noise of 20 um, of which the spectrum of the grid cannot tell it apart."""
    fine, _ = jc.wall_pair(14.0, (256, 256), SPACING / 2.0, 3, 0.5, roll_off=None,
                           unusual_values=True)  # fmt: skip
    low, _ = quality_of(scan_of(fine[::2, ::2])).noise
    assert low == 0.0
    turned = -scipy.ndimage.shift(fine, 1.0, mode="mirror")[::2, ::2]
    assert noise_of(turned, fine[::2, ::2])[1] > 10e-6


def test_noise_is_found_beside_missing_or_rounded_heights():
    fine, _ = jc.wall_pair(6.0, (256, 256), SPACING / 2.0, 5, 0.8, unusual_values=True)
    random = np.random.default_rng(5)
    heights = np.round(fine[::2, ::2] + 15e-6 * random.standard_normal((128, 128)), 5)
    heights[random.random(heights.shape) < 0.05] = np.nan
    low, high = quality_of(scan_of(heights)).noise
    assert 4e-6 < low < 15e-6 < high < 25e-6


def test_a_filtered_scan_tells_no_noise():
    fine, _ = jc.wall_pair(8.0, (128, 128), SPACING, 5, 0.8, roll_off=None, unusual_values=True)
    assert np.isnan(quality_of(scan_of(scipy.ndimage.uniform_filter(fine, 3))).noise).all()


@pytest.mark.parametrize("radius", [0.8, 1.0])
@pytest.mark.parametrize("cells", [48, 72])
def test_a_spectrum_that_ends_at_a_circle_is_warned_of_and_its_noise_is_stated(radius, cells):
    """By growth with distance alone, the interval ended below the noise, at 0 in most scans."""
    for seed in range(3):
        wall, _ = jc.wall_pair(8.0, (2 * cells, 2 * cells), SPACING, seed, roll_off=None,
                               unusual_values=True)  # fmt: skip
        wall = ended(wall, radius)[:cells, :cells]
        noise = 0.1 * np.sqrt(np.mean(np.diff(wall, axis=1) ** 2))
        heights = wall + noise * np.random.default_rng(seed).standard_normal(wall.shape)
        assert remarks_on(wall)
        (line,) = remarks_on(heights)
        assert "noise of the scanner is understated" in line
        low, high = quality_of(scan_of(heights)).noise
        assert low <= noise <= high < 3.0 * noise


def test_the_end_of_a_spectrum_is_that_of_the_circle():
    wall, _ = jc.wall_pair(8.0, (160, 160), SPACING, 7, roll_off=None, unusual_values=True)
    end = spectrum_end(scan_of(ended(wall, 0.8)[:80, :80] + 2e-6 * np.random.default_rng(7)
                               .standard_normal((80, 80))))  # fmt: skip
    assert end.wave == pytest.approx(2.0 * SPACING / 0.8, rel=0.07)
    assert end.noise == pytest.approx(2e-6, rel=0.15)
    assert not spectrum_end(scan_of(wall)).clear
    assert spectrum_end(scan_of(wall[:20])) is None
    assert spectrum_end(scan_of(np.zeros((40, 40)))) is None
    assert spectrum_end(Scan(wall, (SPACING, 2.0 * SPACING), None)) is None


FILTERS = {
    "mean": lambda wall: scipy.ndimage.uniform_filter(wall, 3),
    "mean, rounded": lambda wall: np.round(scipy.ndimage.uniform_filter(wall, 3), 6),
    "median": lambda wall: scipy.ndimage.median_filter(wall, 3),
    "Gaussian": lambda wall: scipy.ndimage.gaussian_filter(wall, 1.0),
    "Gaussian along y": lambda wall: scipy.ndimage.gaussian_filter1d(wall, 1.0, axis=0),
}


@pytest.mark.parametrize("name", FILTERS)
def test_the_shortest_wave_of_a_filtered_scan_is_that_of_half_of_the_power(name, walls):
    cells = 7.5 if name.startswith("Gaussian") else 6.4
    scan = scan_of(FILTERS[name](walls[1]))
    quality = quality_of(scan)
    assert quality.shortest_wave == pytest.approx(cells * SPACING, rel=0.25)
    assert "holds nothing below" in " ".join(quality_remarks(quality, scan.heights, SPACING))
    assert not quality_remarks(quality, scan.heights, 5.0 * SPACING)


@pytest.mark.parametrize("hurst", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("noise", [0.0, 5e-6])
def test_undamaged_scans_receive_no_warning(hurst, noise):
    for seed, roll_off in ((1, None), (2, 3e-3)):
        fine = jc.wall_pair(
            8.0, (128, 160), SPACING / 2, seed, hurst=hurst, roll_off=roll_off, unusual_values=True
        )
        for wall in noisy((fine[0][::2, ::2], fine[1][:64, :80]), noise):
            scan = inspected(scan_of(wall))
            assert not [*scan.remarks, *quality_remarks(quality_of(scan), wall, SPACING)]
            np.testing.assert_array_equal(scan.heights, wall)


@pytest.fixture(params=[1e-6, 1e-4])
def rounded(request, walls):
    """A step, and a scan whose heights are rounded to it."""
    return request.param, scan_of(np.round(walls[1] / request.param) * request.param)


def test_rounding_of_heights_is_measured(rounded):
    step, scan = rounded
    assert rounding_of(scan).heights == pytest.approx(step, rel=1e-6)


def test_rounding_of_heights_is_compared_with_the_slope_that_it_raises(rounded, walls):
    step, scan = rounded
    remarks = remarks_on(scan.heights)
    assert len(remarks) == (step > 1e-5)
    if remarks:
        slopes = [rms_slope(wall, SPACING) for wall in (walls[1], scan.heights)]
        low, high = map(float, re.search(r"from ([\d.]+) to ([\d.]+),", remarks[0]).groups())
        assert (low, high) == (pytest.approx(slopes[0], rel=0.05), pytest.approx(slopes[1], 1e-2))


def inclined_grid(wall, degrees):
    return wall + np.tan(np.radians(degrees)) * SPACING * np.indices(wall.shape)[1]


def inclined_points(wall, degrees):
    points = points_of(scan_of(wall))
    return scipy.spatial.transform.Rotation.from_euler("y", degrees, degrees=True).apply(points)


def test_rounding_of_an_inclined_grid_is_that_of_the_heights_as_read(walls):
    rounded = [np.round(inclined_grid(wall, 19.0), 4) for wall in (1e-3 - walls[0], walls[1])]
    pair = registered(*map(scan_of, rounded), orientation="common_frame", shift="scanned")
    assert "the scan was turned until it lies level" in " ".join(pair.remarks)
    assert sum("heights are multiples of 100 um" in line for line in pair.warnings) == 2
    assert pair.rounding == pytest.approx(1e-4 * np.sqrt(2.0 / 12.0), rel=1e-6)


def test_spikes_that_are_cut_do_not_change_the_spacing_of_the_joint(walls):
    points = [points_of(scan_of(wall)) for wall in (1e-3 - walls[0], walls[1])]
    random = np.random.default_rng(1)
    for cloud in points:
        cloud[:, :2] += 0.3 * SPACING * random.standard_normal((len(cloud), 2))
    known = {"orientation": "common_frame", "shift": "scanned"}
    whole = registered(*map(Cloud, points), **known)
    for cloud in points:
        cloud[2000:6000:80, 2] += 2e-3
    spiky = registered(*map(Cloud, points), **known)
    assert "of 9216 points are spikes" in " ".join(spiky.remarks)
    assert spiky.spacing == whole.spacing


@pytest.mark.parametrize("filtered", [True, False])
def test_a_filter_shows_in_points_that_lie_on_a_grid_once_they_are_level(filtered, walls):
    given = [FILTERS["mean"](wall) if filtered else wall for wall in (1e-3 - walls[0], walls[1])]
    clouds = [Cloud(inclined_points(wall, 19.0)) for wall in given]
    pair = registered(*clouds, orientation="common_frame", shift="scanned")
    assert sum("holds nothing below" in line for line in pair.warnings) == 2 * filtered
    assert pair.waves == pytest.approx((6.4 * SPACING * filtered,) * 2, rel=0.25)
    alone = registered("flat", clouds[1])
    assert ("holds nothing below" in " ".join(alone.warnings)) == filtered


@pytest.mark.parametrize("number", range(4))
def test_a_grid_that_was_turned_and_tilted_shows_no_noise(number):
    """Its distances along both directions are nearly equal, and walls differ by direction."""
    wall, _ = jc.wall_pair(10.0, (64, 64), SPACING, number, roll_off=None)
    y, x = SPACING * np.indices(wall.shape)
    points = np.column_stack([x.ravel(), y.ravel(), wall.ravel()])
    turned = points @ (rotation("z", 11.0) @ rotation("x", 3.0)).T
    assert noise_of_points(Cloud(turned), point_distance(Cloud(turned))) == 0.0


@pytest.mark.parametrize("apart", [0.0, 0.1e-3])
def test_passes_of_a_scanner_that_lie_apart_are_measured(apart):
    fine = jc.wall_pair(8.0, (200, 200), SPACING / 4, 1, roll_off=None, unusual_values=True)[0]
    passes = [
        (place, fine[place::4, place::4] + height) for place, height in ((0, 0.0), (2, apart))
    ]
    points = [
        np.column_stack(
            [*(SPACING / 4 * (first + 4 * np.indices(w.shape)).reshape(2, -1)), w.ravel()]
        )
        for first, w in passes
    ]
    cloud = Cloud(np.concatenate(points))
    assert noise_of_points(cloud, point_distance(cloud)) == pytest.approx(
        np.sqrt(0.5) * apart, rel=0.1
    )
