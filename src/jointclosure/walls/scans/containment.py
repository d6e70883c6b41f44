"""Refusal of HDF5 files (netCDF-4 among them) whose data lie in other files.

External storage, external links and virtual datasets name files of the machine, which the HDF5
library would open and read as heights. They are found by their bytes, without opening anything:
messages of the HDF5 file format specification, version 3, sections III.G, IV.A.2.g, h and i.
"""

import mmap
import re
import struct
from collections.abc import Iterator
from pathlib import Path

from jointclosure.inputs import InputError

_MAGIC = b"\x89HDF\r\n\x1a\n"  # first bytes of an HDF5 file
_STARTS = (0, *(512 << power for power in range(20)))  # where the first block of a file may be
_LINK = re.compile(rb"\x01[\x08-\x1f]\x40", re.DOTALL)  # version, flags with a type, external
_EXTERNAL = re.compile(rb"\x01\x00\x00\x00(..)(..)\Z", re.DOTALL)  # slots: allocated and used


def check_contained(path: Path) -> None:
    """Raise `InputError` if a file is HDF5 and has data in other files."""
    with path.open("rb") as file:
        base = next((start for start in _STARTS if _bytes_at(file, start) == _MAGIC), None)
        if base is None:
            return
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            what = _reference_to_other_file(content, base)
    if what is not None:
        raise InputError(
            f"has {what}, so that heights would be read from another file: must contain its data; "
            "copy them into one file"
        )


def _bytes_at(file, start: int) -> bytes:
    """Return the bytes of a file at a place, as many as `_MAGIC` has."""
    file.seek(start)
    return file.read(len(_MAGIC))


def _reference_to_other_file(content: mmap.mmap, base: int) -> str | None:
    """Return the kind of reference to another file in the content of an HDF5 file; None without.

    ``base`` is where the HDF5 data begin.
    """
    for heap in _find_all(content, b"HEAP"):
        for place in _find_all(content, struct.pack("<Q", heap - base)):
            slots = _EXTERNAL.search(content[max(place - 8, 0) : place])
            if slots and 0 < int.from_bytes(slots[2], "little") <= int.from_bytes(
                slots[1], "little"
            ):
                return "external storage"
    for heap in _find_all(content, b"GCOL"):
        for place in _find_all(content, struct.pack("<Q", heap - base)):
            if content[max(place - 2, 0) : place] in (b"\x04\x03", b"\x05\x03"):
                return "a virtual dataset"
    if any(_is_external_link(content, match.start()) for match in _LINK.finditer(content)):
        return "an external link"
    return None


def _find_all(content: mmap.mmap, word: bytes) -> Iterator[int]:
    """Generate the places at which the bytes ``word`` occur in a file."""
    place = content.find(word)
    while place >= 0:
        yield place
        place = content.find(word, place + 1)


def _is_external_link(content: mmap.mmap, start: int) -> bool:
    """Return whether an external link is stored at the place ``start`` of an HDF5 file.

    The bytes there must be a name of the link, then the names of a file and of an object in it.
    """
    flags = content[start + 1]
    place = start + 3
    place += 8 * bool(flags & 4) + bool(flags & 16)  # order of creation, character set
    width = 1 << (flags & 3)
    size = int.from_bytes(content[place : place + width], "little")
    place += width + size
    length = int.from_bytes(content[place : place + 2], "little")
    value = content[place + 2 : place + 2 + length]
    names = value[1:].split(b"\0")
    whole = 0 < size < 65_536 and len(value) == length > 3 and value[0] == 0
    return whole and len(names) == 3 and not names[2] and all(map(_is_name, names[:2]))


def _is_name(text: bytes) -> bool:
    return bool(text) and not re.search(rb"[\x00-\x1f\x7f]", text)
