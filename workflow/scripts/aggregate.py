"""Put all cases of a study into one dataset."""

from jointclosure.dataset import provenance, read_netcdf, write_netcdf
from jointclosure.logbook import Logbook, logging_to
from jointclosure.study.cases import Case
from jointclosure.study.ensemble import join_cases


def main(inputs: list[str], configuration: dict, cases: list[dict], output: str, log: Logbook):
    """Write the study's dataset, with its configuration and provenance as attributes."""
    study = join_cases([Case(**case) for case in cases], [read_netcdf(path) for path in inputs])
    study.attrs = {
        "title": f"closure of rough joints, study {configuration['study']['name']}",
        "references": "Rezaei Niya & Selvadurai, Modeling the Approach of Non-mated Rock Fracture "
        "Surfaces Under Quasi-static Normal Load Cycles",
    } | provenance(configuration)
    write_netcdf(study, output)
    log(f"wrote {output}: {dict(study.sizes)}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(
            snakemake.input,
            snakemake.params.configuration,
            snakemake.params.cases,
            snakemake.output[0],
            logbook,
        )
