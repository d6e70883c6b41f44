import numpy as np
import pytest
import xarray as xr

from jointclosure.storage.netcdf import write_netcdf
from studies import __main__ as cli
from studies.commands.compare import (
    TARGETS,
    by_rock,
    closure_changes,
    differences,
    surfaces_sentence,
)

CASES = ["slate-base", "slate-jrc-low"]


def study(factor=1.0, seeds=range(6), noise=1):
    """A study of one rock whose closures are a factor times random numbers by seed."""
    rng = np.random.default_rng(noise)
    closures = factor * (1e-3 + 1e-4 * rng.standard_normal((2, len(seeds), 2)))
    names = np.array([[f"{seed:032x}" for seed in seeds]] * 2, dtype=object)
    dimensions = ("case", "realization", "cycle")
    return xr.Dataset(
        dict.fromkeys(TARGETS, (dimensions, closures))
        | {
            "status": (dimensions[:2], np.zeros((2, len(seeds)), np.int16)),
            "timing_simulation": (dimensions[:2], rng.random((2, len(seeds)))),
        },
        coords={
            "case": np.array(CASES, dtype=object),
            "rock": ("case", np.array(["slate"] * 2, dtype=object)),
            "parameter": ("case", np.array(["base", "jrc"], dtype=object)),
            "level": ("case", np.array(["base", "low"], dtype=object)),
            "cycle": [1, 2],
            "seed": (dimensions[:2], names),
        },
        attrs={"source_digest": "abc", "provenance_commit": str(noise)},
    )


def test_surfaces_with_the_same_seeds_are_compared_one_by_one():
    changes = closure_changes(study(), study(1.1))
    assert changes.same_surfaces.all()
    np.testing.assert_allclose(changes.change_percent, 10.0)
    # a constant factor: the differences scatter a tenth of what the closures do
    assert changes.standard_error_percent.max() < 0.6
    assert "the same surfaces" in surfaces_sentence(changes)
    for seeds in (range(10, 16), range(5)):
        others = closure_changes(study(), study(1.1, seeds=seeds, noise=2))
        assert not others.same_surfaces.any()
        assert others.standard_error_percent.min() > 1.0
        assert "The surfaces differ in 2 of 2 cases" in surfaces_sentence(others)
    assert len(by_rock(changes)) == 2 * len(TARGETS)


def test_all_that_differs_is_named():
    assert differences(study(), study()) == []
    timed = study()
    timed["timing_simulation"] = 2.0 * timed.timing_simulation
    timed.attrs["provenance_commit"] = "other"
    assert differences(study(), timed) == []
    moved = study()
    moved["max_closure"] = moved.max_closure.copy()
    moved.max_closure[0, 1, 0] += 1e-15
    moved.attrs["source_digest"] = "xyz"
    found = differences(study(), moved.drop_vars("residual_closure"))
    assert found[0] == "attribute source_digest differs"
    assert found[1].startswith("variable max_closure differs in 1 of 24 values, by at most")
    assert found[2] == "variable residual_closure: only in the first"


@pytest.fixture
def folders(tmp_path):
    for name, factor in (("one", 1.0), ("two", 1.1)):
        (tmp_path / name).mkdir()
        write_netcdf(study(factor), tmp_path / name / "study.nc")
    return tmp_path / "one", tmp_path / "two"


def test_compare_exact_fails_where_anything_differs(folders, capsys):
    assert cli.main(["compare", "--exact", *map(str, folders)]) == 1
    assert "variable max_closure differs in 24 of 24" in capsys.readouterr().out
    assert cli.main(["compare", "--exact", str(folders[0]), str(folders[0])]) == 0
    assert capsys.readouterr().out == "identical except for provenance and timing\n"


def test_failures_are_left_out_on_both_sides():
    broken = study(1.1)
    broken["status"][0, 2] = 16
    changes = closure_changes(study(), broken)
    assert changes[changes.case == "slate-base"].samples.unique() == 5
    np.testing.assert_allclose(changes.change_percent, 10.0)
