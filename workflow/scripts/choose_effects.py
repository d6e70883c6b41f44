"""Choose the effects that matter for a rock: one choice for all its cases."""

import json

from jointclosure.config.configuration import effects_of
from jointclosure.ensemble.cases import cases_of
from jointclosure.ensemble.settings import block_settings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.parameters import Effects
from jointclosure.storage.text import write_text
from jointclosure.studies.effects.choice import choose_for_case


def main(configuration: dict, codes: tuple[str, str], output: str, log: Logbook) -> None:
    """Write what is chosen for each case, and the effects that matter in any of them.

    Levels of a parameter are compared with each other, so they have the same effects.
    """
    cases = {case.label: case for case in cases_of(configuration)}
    block = range(configuration["study"]["realizations"])
    found = {}
    for label, case in cases.items():
        log(f"{label}:")
        settings = block_settings(configuration, cases, label, block, *codes)
        found[label] = choose_for_case(case, settings, log)
    together = Effects(*map(any, zip(*(choice.effects for choice in found.values()), strict=True)))
    log(f"for all cases: {together}")
    told = {label: choice._asdict() for label, choice in found.items()}
    for each in told.values():
        each["effects"] = each["effects"]._asdict()
    allowed = effects_of(configuration, next(iter(cases.values())).rock)
    error = max(choice.error for choice in found.values()) if together != allowed else 0.0
    chosen = {"effects": together._asdict(), "error": error, "cases": told}
    write_text(json.dumps(chosen, indent=1) + "\n", output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.params.configuration,
            (snakemake.params.surface_code, snakemake.params.solver_code),
            snakemake.output[0],
            logbook,
        )
