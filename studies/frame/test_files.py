"""Files of a configuration that are damaged or meant to do harm: one line with file and reason."""

import pytest

from studies.frame.files import ConfigurationError, read_plain

BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{later}: &{later} [{', '.join(9 * ['*' + earlier])}]\n"
    for earlier, later in zip("abcdefgh", "bcdefghi", strict=True)
)
FILES = {
    "empty": (b"", "is empty"),
    "a list": (b"- study\n- grid\n", "must contain keys and values, not ['study', 'grid']"),
    "latin-1": ("study: {name: caf\xe9}\n".encode("latin-1"), "is not UTF-8 text (byte 0xe9"),
    "a tag": (b"study:\n  name: !!python/object/apply:os.system ['touch ran']\n", "not plain YAML"),
    "a template": (b"__use_yte__: true\nstudy:\n  name: ?open('ran', 'w').name\n", "left out"),
    "a key twice": (b"grid: {cells_x: 5}\ngrid: {cells_y: 6}\n", "line 2: the key grid must be"),
    "an alias bomb": (BOMB.encode(), "its aliases expand to more than 100000"),
    "a recursive anchor": (b"study: &a\n  rocks: *a\n", "an alias refers to itself"),
    "deep": (b"study: " + 5000 * b"[" + 5000 * b"]", "nested"),
    "an unknown anchor": (b"study: *a\n", "line 1: found undefined alias"),
    "minutes": (b"rocks:\n  slate:\n    youngs_modulus_GPa: 1:30\n", "line 3: 1:30 must be"),
    "octal": (b"grid: {cells_x: 010}\n", "line 1: 010 must be a decimal"),
    "a number as a key": (b"grid: {5: 5}\n", "the key 5 must be a text"),
    "two documents": (b"grid: {}\n---\nstudy: {}\n", "not plain YAML: "),
}  # fmt: skip


@pytest.mark.parametrize("kind", FILES)
def test_a_file_that_is_no_configuration_is_refused_in_one_line(kind, tmp_path):
    content, printed = FILES[kind]
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    with pytest.raises(ConfigurationError) as error:
        read_plain(path)
    assert str(error.value).startswith(f"{path}: ")
    assert printed in str(error.value)
    assert "\n" not in str(error.value)


def test_anchors_that_repeat_a_few_values_are_kept(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("a: &some {x: 1, y: 2.5e-3}\nb: *some\nc: {<<: *some, y: -3}\n")
    assert read_plain(path) == {
        "a": {"x": 1, "y": 2.5e-3},
        "b": {"x": 1, "y": 2.5e-3},
        "c": {"x": 1, "y": -3},
    }
