"""Choose the effects that matter for a rock: one choice for all its cases."""

import json

from jointclosure.config.plain import from_plain, to_plain
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.parameters import Effects
from jointclosure.storage.text import write_text
from jointclosure.studies.effects.choice import choose_for_case


def main(settings: dict[str, ClosureSettings], output: str, log: Logbook) -> None:
    """Write what is chosen for each case, and the effects that matter in any of them.

    Levels of a parameter are compared with each other, so they have the same effects.
    """
    found = {}
    for label, told in settings.items():
        log(f"{label}:")
        found[label] = choose_for_case(told, log)
    together = Effects(*map(any, zip(*(choice.effects for choice in found.values()), strict=True)))
    log(f"for all cases: {together}")
    allowed = next(iter(settings.values())).case.effects
    error = max(choice.error for choice in found.values()) if together != allowed else 0.0
    chosen = {"effects": together, "error": error, "cases": found}
    write_text(json.dumps(to_plain(chosen), indent=1) + "\n", output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        settings = from_plain(dict[str, ClosureSettings], snakemake.params.settings)
        main(settings, snakemake.output[0], logbook)
