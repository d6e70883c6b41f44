"""`python -m studies published` on small files in the form of the public repositories."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.engine.measured_joints import measured
from studies import __main__ as studies
from tests.joints import SPACING
from tests.walls.writers import Ground, as_mesh

READINGS = "Number,Disp,sigmaZ\n[-],[mm],[MPa]\n"
ROCK = measured("rock_compliance").value
STRESSES = [0.25, 2.0, 5.25, 8.0, 10.25, 6.0, 0.25]
CLOSURES = [0.0, 0.04, 0.06, 0.07, 0.08, 0.07, 0.03]


def readings() -> str:
    """A later loading whose closures, net of the rock, are `CLOSURES` [mm]."""
    lines = (
        f"{number},{closure + ROCK * (stress - STRESSES[0])},{stress}\n"
        for number, (stress, closure) in enumerate(zip(STRESSES, CLOSURES, strict=True), start=1)
    )
    return READINGS + "".join(lines)


@pytest.fixture
def folder(tmp_path):
    """Clones of both repositories without scans."""
    data = tmp_path / "hm_coupled_fracture_response/hm_data"
    data.mkdir(parents=True)
    x, y = np.meshgrid([-0.07, -0.03, 0.0, 0.03], [-0.03, 0.0, 0.03])
    stress = np.array([[50.0, 0.0, 3.0, 1.0]] * 3)  # the first column is outside of the specimen
    for joint in "123":
        name = f"ethz_-_specimen_vd{joint}_sigmaZ_vs_fractureClosure_hm1.txt"
        (data / name).write_text(readings())
        maps = tmp_path / f"contact_stress_evaluation/data/vd{joint}"
        maps.mkdir(parents=True)
        for axis, values in zip("XYZ", (x, y, stress), strict=True):
            np.savetxt(maps / f"ethz_vd{joint}_120.{axis}.txt", values, fmt="%.10f")
    return tmp_path


def validated(folder, *words) -> pd.DataFrame:
    """The table that the command writes, by joint and quantity."""
    assert (
        studies.main(["published", str(folder), *words, "--output", str(folder / "table.csv")]) == 0
    )
    table = pd.read_csv(folder / "table.csv", dtype={"joint": str})
    return table.set_index(["joint", "quantity"])


def test_files_are_read_net_of_the_rock(folder, capsys):
    table = validated(folder)
    files = table.loc["2"].files
    assert files.later_closure == pytest.approx(0.08)
    half = np.interp(5.125, STRESSES[:5], CLOSURES[:5])
    assert files.later_stiffness == pytest.approx(5.125 / (0.08 - half))
    assert files.later_residual_share == pytest.approx(37.5)
    assert files.contact_share == pytest.approx(100.0 / 3.0)
    assert files.recovered_load == pytest.approx(100.0 * 4.0 / 3.0 / 10.27)
    assert table.loc[("2", "contact_share"), "stored"] == measured("contact_share", "2").value
    assert table.model.isna().all()
    assert "the model was not run" in capsys.readouterr().out


@pytest.mark.parametrize("lost", [1, 2])
def test_what_a_cut_file_lacks_is_missing_with_its_reason(folder, capsys, lost):
    expected = validated(folder)
    file = next(folder.rglob("ethz_-_specimen_vd2_*"))
    file.write_text("".join(readings().splitlines(keepends=True)[:-lost]))
    if lost == 2:
        assert studies.main(["published", str(folder)]) == 2
        assert "stress must rise to its maximum, and fall after it" in capsys.readouterr().err
        return
    table = validated(folder)
    expected.loc[("2", "later_residual_share"), "files"] = np.nan
    pd.testing.assert_frame_equal(table, expected)
    assert "later_residual_share of joint 2 is missing" in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore")  # the walls are small, and their fit is doubtful
def test_scanned_walls_are_closed_as_the_joints_were(folder):
    upper, lower = jc.wall_pair(8.0, (32, 32), SPACING, seed=4, mismatch_wavelength=1e-3)
    for joint in "123":
        for side, wall in (("a", -upper), ("b", lower)):
            place = folder / f"hm_coupled_fracture_response/surface_scans/ethz_vd{joint}{side}.stl"
            place.parent.mkdir(exist_ok=True)
            as_mesh(place, Ground(1e3 * wall, 1e3 * SPACING))
    after = folder / "hm_coupled_fracture_response/surface_scans/ethz_post_vd1a.stl"
    after.write_bytes(b"not read")
    model = validated(folder, "--units", "mm").model
    assert 0.0 < model["1", "later_closure"] <= model["1", "first_closure"]
    assert model["1", "later_residual_share"] == pytest.approx(0.0, abs=2.0)
    assert model["1"].drop("recovered_load").notna().all()


CURVE, MAP = "ethz_-_specimen_vd1_*", "ethz_vd1_120.Z.txt"


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        (CURVE, "", None, "ethz_-_specimen_vd1_sigmaZ_vs_fractureClosure_hm1.txt: no such file"),
        (CURVE, READINGS, "", "column '2': has no unit"),
        (CURVE, "mm", "inch", "unit 'inch' must be one of"),
        (MAP, "3.0000000000", "nan", "ethz_vd1_120.Z.txt: 2 values are not finite"),
        ("other.stl", "", "", "0 scans of wall vd1a before testing, must be one"),
    ],
)
def test_files_of_another_form_are_refused(folder, capsys, file, old, new, message):
    path = next(folder.rglob(file), folder / file)
    if new is None:
        path.unlink()
    else:
        path.write_text(path.read_text().replace(old, new, 2) if path.exists() else "")
    assert studies.main(["published", str(folder)]) == 2
    assert message in capsys.readouterr().err


def test_units_of_readings_are_those_of_their_line(folder):
    expected = validated(folder)
    file = next(folder.rglob("ethz_-_specimen_vd1_*"))
    lines = (line.split(",") for line in readings().removeprefix(READINGS).splitlines())
    rows = [f"{number},{1e3 * float(closure)},{1e3 * float(s)}\n" for number, closure, s in lines]
    file.write_text("Number,Disp,sigmaZ\n[-],[um],[kPa]\n" + "".join(rows))
    pd.testing.assert_frame_equal(validated(folder), expected)
