"""Choose the effects that the cases of a rock need, on the surfaces of one of them."""

from jointclosure.ensembles.quantities import names_of_case
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.pilots import choose_rock_effects
from studies.frame.settings import walls_in

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        choice = snakemake.params.choice
        walls = walls_in(snakemake.input.surfaces, choice.point.settings)
        names = names_of_case(snakemake.params.flow)
        chosen = choose_rock_effects(choice, walls, names, log)
        write_netcdf(chosen.assign_attrs(key=snakemake.params.key), snakemake.output[0])
