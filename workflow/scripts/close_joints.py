"""Close the joints of a block of realisations of a case over their load cycles."""

from jointclosure.ensembles.quantities import names_of_case
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.checked_files import read_checked
from studies.frame.settings import walls_in
from studies.frame.simulation import close_joints, under_chosen

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        point, closed = snakemake.params.point, {}
        ensemble, study = snakemake.wildcards.ensemble, snakemake.config["study"]["name"]
        other = "" if ensemble == "cases" else f"--{ensemble} "
        label = point.settings.case.label
        if snakemake.input.effects:
            pilot = read_checked(snakemake.input.effects, snakemake.params.effects_key)
            point, closed = under_chosen(point, pilot)
        joints = close_joints(
            point,
            walls_in([snakemake.input.surfaces], point.settings),
            names_of_case(snakemake.params.flow),
            report=log,
            closed=closed,
            repeat=f"python -m studies repeat {other}results/{study} {label}",
        )
        write_netcdf(joints.assign_attrs(key=snakemake.params.key), snakemake.output[0])
