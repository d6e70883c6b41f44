"""Joints of a study depend on their settings, and not on how the work is split."""

import itertools
import shutil

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from jointclosure.ensembles.quantities import names_of_case
from jointclosure.storage.files import DamagedFileError
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.commands.differences import differences
from studies.frame import datasets, simulation
from studies.frame.cases import (
    JOB_SECONDS,
    blocks_of,
    cases_of,
    expected_seconds,
    first_with_surfaces,
)
from studies.frame.checked_files import ForeignFileError, read_checked
from studies.frame.datasets import CURVES, joints_key, of_case, read_joints, write_ensemble
from studies.frame.experiments import case_point
from studies.frame.joint_tables import join_cases
from studies.frame.settings import surface_settings, surfaces_dataset, walls_in, walls_of
from studies.frame.simulation import close_joints, close_points
from tests.studied import study_of

ELASTIC = {"substrate": True, "interaction": True, "breakage": False, "gouge": False}


SMALL = {
    "grid": {"cells_x": 12, "cells_y": 12},
    "effects": ELASTIC,
    "numerics": {"curve_points": 5},
    "output": {"stress_points": 4},
    "study": {"rocks": ["slate"], "realizations": 7},
    "rocks": {"slate": {"levels": dict.fromkeys(("youngs_modulus_GPa", "poisson_ratio"))}},
}
"""The paper's study of joints of 12 x 12 cells that do not break."""
NAMES = names_of_case(flow=False)


def point_of(label, block, *changes):
    """Return the point of a case of the small study with changes, for a block of realisations."""
    study = study_of(SMALL, *changes)
    return case_point(study, {case.label: case for case in cases_of(study)}[label], block)


# Blocks of realisations, one a job


@given(st.integers(2, 500), st.integers(1, 600) | st.none())
def test_blocks_have_every_realisation_once(realizations, per_job):
    study = study_of()
    keys = study.study._replace(realizations=realizations, realizations_per_job=per_job)
    blocks = blocks_of(study._replace(study=keys))
    assert list(itertools.chain(*blocks)) == list(range(realizations))
    assert all(len(block) <= (per_job or realizations) for block in blocks)


@pytest.mark.parametrize("side", [20, 100, 200, 400, 1000])
def test_large_joints_are_split_into_more_jobs_by_their_expected_time(side):
    study = study_of({"grid": {"cells_x": side, "cells_y": side}})
    blocks = blocks_of(study)
    longest = max(len(block) for block in blocks)
    assert longest == 1 or longest * expected_seconds(study) <= 1.5 * JOB_SECONDS
    assert (len(blocks) > 1) == (20 * expected_seconds(study) > JOB_SECONDS)


def test_blocks_of_an_accuracy_are_only_added():
    study = study_of({"study": {"accuracy": {"within": 0.1}}})
    first = blocks_of(study, 20)
    more = blocks_of(study, 50)
    assert more[: len(first)] == first
    assert list(itertools.chain(*more)) == list(range(50))


# Surfaces that cases share, and the files that have them


def shared_by(*changes):
    """Return for each case the first one with the same surfaces, by label."""
    study = study_of(SMALL, {"study": {"rocks": ["slate", "dolerite"]}}, *changes)
    return first_with_surfaces(study, {case.label: case for case in cases_of(study)})


def test_cases_with_equal_settings_of_surfaces_share_them():
    shared = shared_by({"study": {"draws": "common"}})
    assert shared["slate-compressive_strength-low"] == shared["slate-base"] == "slate-base"
    assert shared["slate-jrc-low"] == "slate-jrc-low"
    assert shared["dolerite-base"] == "dolerite-base"
    independent = shared_by()
    assert all(first == label for label, first in independent.items())


def test_walls_come_bit_by_bit_out_of_the_files_of_their_blocks(tmp_path):
    pairs = []
    files = []
    for block in (range(3), range(3, 5)):
        settings = surface_settings(point_of("slate-jrc-low", block).settings)
        pairs += walls_of(settings)
        files.append(str(tmp_path / f"{block.start}.nc"))
        write_netcdf(surfaces_dataset(walls_of(settings), settings), files[-1])
    whole = surface_settings(point_of("slate-jrc-low", range(5)).settings)
    for pair, stored in zip(pairs, walls_in(files, whole), strict=True):
        np.testing.assert_array_equal(pair, stored)
    np.testing.assert_array_equal(list(walls_of(whole)), pairs)
    assert read_netcdf(files[1]).realization.values.tolist() == [3, 4]


def test_surfaces_of_another_case_or_of_other_realisations_are_refused(tmp_path):
    file = tmp_path / "surfaces.nc"
    made = surface_settings(point_of("slate-jrc-low", range(3)).settings)
    write_netcdf(surfaces_dataset(walls_of(made), made), file)
    base = point_of("slate-base", range(3)).settings
    with pytest.raises(ForeignFileError, match=f"{file}: is not of this study .*: delete it"):
        next(walls_in([file], base))
    later = point_of("slate-jrc-low", range(3, 6)).settings
    with pytest.raises(ForeignFileError, match="begins with realisation 0, must begin with 3"):
        next(walls_in([file], later))


# What a result depends on


CHANGES = [
    {"study": {"root_seed": 1}}, {"surface": {"hurst": 0.7}}, {"grid": {"spacing_mm": 0.5}},
    {"effects": {"soft_peaks": False}}, {"numerics": {"force_tolerance": 1e-9}},
    {"output": {"stress_points": 5}}, {"rocks": {"slate": {"youngs_modulus_GPa": 66.5}}},
]  # fmt: skip


def test_all_that_joints_depend_on_is_in_their_key():
    low = point_of("slate-jrc-low", range(4))
    others = [point_of("slate-jrc-low", range(4), edit) for edit in CHANGES]
    others.append(point_of("slate-jrc-high", range(4)))
    keys = {joints_key(point, "code") for point in (low, *others)} | {joints_key(low, "other")}
    assert len(keys) == len(others) + 2
    other = {"rocks": {"slate": {"levels": {"jrc": [5, 9.5]}, "title": "Another"}}}
    for block, edit in ((range(4), other), (range(4, 7), {}), (range(7), other)):
        same = point_of("slate-jrc-low", block, edit)
        assert joints_key(same, "code") == joints_key(low, "code")


def test_surfaces_depend_neither_on_the_rock_nor_on_numerics():
    low = point_of("slate-jrc-low", range(4))
    for edit, same in zip(CHANGES, (0, 0, 0, 1, 1, 1, 1), strict=True):
        other = point_of("slate-jrc-low", range(4), edit)
        assert (surface_settings(other.settings) == surface_settings(low.settings)) == same


# One dataset of all cases


def closed_in(folder, *changes):
    """Simulate all cases and blocks of a small study with changes; return files, keys and cases."""
    study = study_of(SMALL, {"rocks": {"slate": {"levels": {"jrc": None}}}}, *changes)
    cases = cases_of(study)
    keys = {case.label: joints_key(case_point(study, case, range(0)), "code") for case in cases}
    files = []
    for case, block in itertools.product(cases, blocks_of(study)):
        point = case_point(study, case, block)
        joints = close_joints(point, point.walls(), NAMES).assign_attrs(key=keys[case.label])
        files.append(str(folder / f"{case.label}.{block.start}-{block.stop - 1}.nc"))
        write_netcdf(joints, files[-1])
    return files, keys, cases


def joined(folder, files, keys, cases):
    output = folder / "study.nc"
    write_ensemble(files, keys, cases, {"key": "study"}, output, lambda line: None)
    return read_netcdf(output)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Files, keys and cases of a small study, a file for each case."""
    return closed_in(tmp_path_factory.mktemp("whole"))


@pytest.fixture(scope="module")
def split(tmp_path_factory):
    """Files, keys and cases of a small study, in blocks of three realisations."""
    blocks = {"study": {"realizations_per_job": 3}}
    return closed_in(tmp_path_factory.mktemp("split"), blocks)


@pytest.fixture(scope="module")
def by_few_rows(whole, tmp_path_factory):
    """The small study, joined by no more than four rows, and the rows of each part."""
    sizes = []

    def watched(frame, path, regions, *how):
        parts = list(regions)
        sizes.extend(part.sizes["realization"] for _, part in parts)
        write_netcdf(frame, path, parts, *how)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(datasets, "write_netcdf", watched)
        patch.setattr(datasets, "ROWS", 4)
        return joined(tmp_path_factory.mktemp("joined"), *whole), sizes


def test_few_rows_of_a_study_are_in_memory(by_few_rows):
    study, sizes = by_few_rows
    assert set(sizes) == {4, 3}
    assert study.realization.values.tolist() == list(range(7))
    assert np.isfinite(study.max_closure.values).all()


def test_a_split_over_jobs_changes_no_bit(by_few_rows, whole, split, tmp_path, monkeypatch):
    monkeypatch.setattr(datasets, "ROWS", 4)
    assert len(split[0]) == 3 * len(whole[0])
    assert differences(by_few_rows[0], joined(tmp_path, *split)) == []


def test_a_study_by_few_rows_is_that_of_all_rows_at_once(by_few_rows, whole):
    files, _, cases = whole
    at_once = join_cases(cases, [of_case(read_netcdf(file)) for file in files])
    study = by_few_rows[0].drop_vars("scene")
    assert differences(study, at_once.drop_attrs(deep=False)) == [
        "attribute key: only in the first"
    ]


def test_joints_that_are_read_without_curves_are_those_of_the_dataset(split, tmp_path):
    study = joined(tmp_path, *split).drop_vars([*CURVES, "scene"], errors="ignore")
    read = read_joints(*split)
    for name in read.data_vars:
        np.testing.assert_array_equal(read[name].values, study[name].values)
    assert set(read.data_vars) == set(study.data_vars)
    assert read.seed.values.tolist() == study.seed.values.tolist()


READERS = {
    "write_ensemble": joined,
    "read_joints": lambda folder, *given: read_joints(*given),
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("kind", ["damaged", "foreign", "another file", "twice", "missing"])
def test_a_file_that_is_not_of_the_study_is_named_before_any_is_joined(
    split, tmp_path, kind, reader
):
    files, keys, cases = split
    files = [shutil.copy(file, tmp_path) for file in files]
    wrong = files[4]
    error = ForeignFileError
    message = r"is not of this study .*: delete it"
    if kind == "damaged":
        with open(wrong, "r+b") as file:
            file.truncate(2000)
        error = DamagedFileError
        message = ""
    elif kind == "foreign":
        other = read_netcdf(wrong).assign_attrs(
            key=joints_key(point_of("slate-base", range(3)), "")
        )
        write_netcdf(other, wrong)
    elif kind == "another file":
        write_netcdf(xr.Dataset({"x": ("n", [1.0])}), wrong)
    elif kind == "twice":
        shutil.copy(files[0], wrong)
        message = f"has realisation 0 of {cases[0].label}, as {files[0]} has: delete both"
    else:
        files.remove(wrong)
        wrong = cases[1].label
        message = "no file of joints has its realisation 3: delete its files"
    with pytest.raises(error, match=f"{wrong}: .*{message}") as raised:
        READERS[reader](tmp_path, files, keys, cases)
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "study.nc").exists()


def test_a_dataset_is_read_by_its_key_only(whole, tmp_path):
    joined(tmp_path, *whole)
    study = tmp_path / "study.nc"
    read = read_checked(study, "study", without=CURVES)
    assert "max_closure" in read
    assert not set(CURVES) & set(read.data_vars)
    with pytest.raises(ForeignFileError, match=rf"{study}: is not of this study .*: delete it"):
        read_checked(study, "other")
    write_netcdf(read.drop_attrs(deep=False), study)
    with pytest.raises(ForeignFileError):
        read_checked(study, "study")
    assert study.exists()


def test_an_edited_dataset_is_not_read_though_it_has_the_key(whole, tmp_path):
    joined(tmp_path, *whole)
    study = tmp_path / "study.nc"
    content = bytearray(study.read_bytes())
    content[len(content) // 2] ^= 1
    study.write_bytes(content)
    with pytest.raises(DamagedFileError, match=f"{study}: "):
        read_checked(study, "study")


# Joints that cannot be closed


def test_no_joint_of_a_point_is_simulated_after_one_that_ends_it(monkeypatch):
    row = {"status": 0, "timing_simulation": 1.0}
    monkeypatch.setattr(simulation, "simulate_row", lambda pair, reading: row)
    points = [point_of("slate-base", range(2))._replace(coordinates={"variant": n}) for n in "ab"]
    joints = close_points(points, (), ends=lambda point, row: point.coordinates["variant"] == "a")
    assert joints.variant.values.tolist() == ["a", "b", "b"]


def test_an_error_names_the_command_that_repeats_its_realisation(monkeypatch):
    def failing(pair, reading):
        raise FloatingPointError("no number")

    monkeypatch.setattr(simulation, "simulate_row", failing)
    point = point_of("slate-base", range(4, 6))
    with pytest.raises(FloatingPointError) as error:
        close_joints(point, point.walls(), NAMES, repeat="repeat r slate-base")
    assert error.value.__notes__ == ["realisation 4; to repeat it: repeat r slate-base 4"]
