# What the rules of the study of the scale effect share: what is closed, and its seals. No rules here.
from jointclosure.studies.size import closing as sized

SIZE = CONFIGURATION.size
SPECTRA = list(SIZE.spectra) if SIZE else []
SIZE_TABLES = ["size", "size_exponents", "size_collapse", "size_barton_bandis"]


def size_of(rock, spectrum):
    """Settings of the joints of a rock and a spectrum, as plain data."""
    return to_plain(sized.settings_of(CONFIGURATION, rock, spectrum))


SIZE_WITH = {
    seals_of(f"close_size/{rock}.{spectrum}")[0]: settings_digest(
        {"settings": size_of(rock, spectrum), "code": code_of("close_size")}
    )
    for rock in (ROCKS if SIZE else [])
    for spectrum in SPECTRA
}


wildcard_constraints:
    spectrum="[a-z0-9_]+",
