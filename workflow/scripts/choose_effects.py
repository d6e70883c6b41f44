"""Choose the effects that matter for a rock: one choice for all its cases."""

import json

import xarray as xr

from jointclosure.engine.choice import RockChoice, choose_for_rock
from jointclosure.engine.joints import closed_before
from jointclosure.engine.settings import ClosureSettings
from jointclosure.engine.surfaces import surfaces_of
from jointclosure.inputs.plain import from_plain, to_plain
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.text import write_text
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(settings: dict[str, ClosureSettings], outputs: dict[str, str], log: Logbook) -> None:
    """Write the effects that matter, and the joints that the pilot closed with them."""
    choice = choose_for_rock(settings, log)
    chosen = {"effects": choice.effects, "error": choice.error}
    chosen["cases"] = {
        label: {"effects": case.effects, "error": case.error, "reasons": case.reasons}
        for label, case in choice.cases.items()
    }
    write_text(json.dumps(to_plain(chosen), indent=1) + "\n", outputs["chosen"])
    write_netcdf(_closed(settings, choice), outputs["closed"])


def _closed(settings: dict[str, ClosureSettings], choice: RockChoice) -> xr.Dataset:
    """Join the joints that the pilots closed with the selected effects, over (realization)."""
    parts = []
    for label, case in choice.cases.items():
        used = settings[label].with_effects(choice.effects)
        part = closed_before(surfaces_of(used.surfaces), case.closed, used)
        cases = [label] * part.sizes["realization"]
        parts.append(part.assign_coords(case=("realization", cases)))
    return xr.concat(parts, "realization")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        settings = from_plain(dict[str, ClosureSettings], snakemake.params.settings)
        main(settings, dict(snakemake.output), logbook)
