"""Commands as a user calls them, and small inputs for them."""

import contextlib
import io
from pathlib import Path

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.cli.main import main
from jointclosure.plotting.style import StyledFigure
from tests.joints import SPACING
from tests.measured.test_likelihood import GOOD


@pytest.fixture(autouse=True, scope="module")
def one_processor():
    """Make commands see one processor: starting processes takes longer than small joints."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.sched_getaffinity", lambda process: {0}, raising=False)
        yield


def status_of(*words):
    """Run a command as a user types it."""
    try:
        return main([str(word) for word in words])
    except SystemExit as ended:  # of the parser of arguments
        return ended.code


@pytest.fixture
def command(capsys):
    """Function that runs a command, and returns its status, output and errors."""
    return lambda *words: (status_of(*words), *capsys.readouterr())


@pytest.fixture(scope="module")
def shared_command():
    """As `command`, for fixtures whose results several tests read."""

    def run(*words):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = status_of(*words)
        return status, out.getvalue(), err.getvalue()

    return run


def leave_undrawn(patch):
    """Make figures, but do not draw them, which takes half a second each."""
    patch.setattr(
        StyledFigure, "savefig", lambda figure, path, **_: Path(path).write_bytes(b"undrawn")
    )


@pytest.fixture
def undrawn(monkeypatch):
    leave_undrawn(monkeypatch)


def write_points(path, heights):
    """Write a scan [mm] as instruments do: with a header, and separators at the ends of lines."""
    y, x = np.indices(heights.shape) * 1e3 * SPACING
    points = np.column_stack([x.ravel(), y.ravel(), 1e3 * heights.ravel()])
    lines = [",".join(f"{value:.6f}" for value in point) + "," for point in points]
    path.write_text("\n".join(["x,y,z", "x,y,z", *lines]))


@pytest.fixture(scope="session")
def inputs(tmp_path_factory):
    """Folder with both walls of a joint (z upwards; points and arrays), a single wall, a curve."""
    folder = tmp_path_factory.mktemp("inputs")
    upper, lower = jc.wall_pair(9.0, (48, 56), SPACING, seed=4, correlation=0.9, roll_off=None)
    for name, heights in (("top", 0.6e-3 - upper), ("bottom", lower)):
        write_points(folder / f"{name}.xyz", heights)
        np.save(folder / f"{name}.npy", 1e3 * heights)
    np.save(folder / "wall.npy", 1e3 * jc.wall_pair(9.0, (40, 48), SPACING, seed=1)[0])
    (folder / "lab.csv").write_text(GOOD)
    return folder
