"""Close the joints of an ensemble that are missing, and join all in one dataset."""

import json
from pathlib import Path

from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.closing import Ensemble, chosen_in
from studies.frame.configuration import resolved
from studies.frame.files import provenance
from studies.frame.jobs import job, listed
from studies.frame.walls import described


def main(
    ensemble: Ensemble, stated: dict, walls: list[str], outputs: dict, workers: int, log: Logbook
):
    """Write the dataset of an ensemble with the keys ``stated`` of it, and its first walls."""
    output = Path(outputs["joints"])
    folder = output.parent
    entries = ensemble.close(folder, workers, log)
    attributes = {
        "title": f"closure of rough joints, study {ensemble.configuration.study.name}",
        "ensemble": ensemble.name,
        "references": "Rezaei Niya & Selvadurai, Modeling the Approach of Non-mated Rock Fracture "
        "Surfaces Under Quasi-static Normal Load Cycles",
    } | provenance(stated)
    if pilots := ensemble.pilots(folder):
        chosen = {rock: chosen_in(pilot.file(folder)) for rock, pilot in pilots.items()}
        attributes["effects_chosen"] = json.dumps(chosen)
    if walls:
        attributes["walls"] = described({Path(path).stem: read_netcdf(path) for path in walls})
    if "first_walls" in outputs:
        write_netcdf(ensemble.first_walls(folder), outputs["first_walls"])
    ensemble.join(entries, folder, attributes, output, log)
    log(f"wrote {output}: {len(ensemble.cases)} cases")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        logbook(f"configuration: {json.dumps(snakemake.config)}")
        params = snakemake.params
        main(
            Ensemble(resolved(snakemake.config), params.ensemble),
            params.configuration,
            listed(snakemake.input.walls),
            dict(snakemake.output),
            snakemake.threads,
            logbook,
        )
