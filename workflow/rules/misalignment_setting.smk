# What the rules of the study of misalignment share: the design, what is closed, and its seals. No rules here.
from jointclosure.studies.misalignment import design as misaligned

MISALIGNMENT = misaligned.design_of(config) if config.get("misalignment") else None
MISALIGNED_LABELS = list(MISALIGNMENT.wavelengths) if MISALIGNMENT else []


def misalignment_of(rock, label):
    """Settings of the closures of a rock at a mismatch wavelength, as plain data."""
    return to_plain(misaligned.settings_of(MISALIGNMENT, CONFIGURATION, rock, label))


MISALIGNMENT_WITH = {
    seals_of(f"close_misalignment/{rock}.{label}")[0]: settings_digest(
        {
            "settings": misalignment_of(rock, label),
            "code": code_of("close_misalignment"),
        }
    )
    for rock in (ROCKS if MISALIGNMENT else [])
    for label in MISALIGNED_LABELS
}
