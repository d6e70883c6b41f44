# What the rules of the study of mismatch share: the design, what is closed, and its seals. No rules here.
from jointclosure.studies.mismatch import closing as mismatched

MISMATCH = CONFIGURATION.mismatch
WAVELENGTHS = mismatched.labels_of(CONFIGURATION) if MISMATCH else {}


def mismatch_of(rock, label):
    """Settings of the closures of a rock at a mismatch wavelength, as plain data."""
    return to_plain(mismatched.settings_of(CONFIGURATION, rock, WAVELENGTHS[label]))


MISMATCH_WITH = {
    seals_of(f"close_mismatch/{rock}.{label}")[0]: settings_digest(
        {"settings": mismatch_of(rock, label), "code": code_of("close_mismatch")}
    )
    for rock in (ROCKS if MISMATCH else [])
    for label in WAVELENGTHS
}


wildcard_constraints:
    label="[a-z0-9.]+",
