# Shared by the rules of joints and experiments: what is closed, and its entries of the cache. No rules here.
# Every job reads this file anew: slow checks run in the main process only, and slow values are made on demand.
from studies.frame.experiments import cached, experiments_in
from jointclosure.engine.cache import digest
from studies.frame.cases import dataset_of, ensembles_of
from studies.frame.closing import Ensemble

EXPERIMENTS = experiments_in(config)
for experiment in EXPERIMENTS.values():
    if workflow.is_main_process:
        experiment.check(CONFIGURED)
DESIGNS = {
    name: experiment.design(CONFIGURED) for name, experiment in EXPERIMENTS.items()
}


def table_file(table):
    """File of a table by its name; that of a text has its ending."""
    return f"{RESULTS}/tables/{table}{'' if '.' in table else '.csv'}"


ENSEMBLES = {
    name: Ensemble(CONFIGURATION, name) for name in ensembles_of(CONFIGURATION)
}
PILOTS = [entry.name for entry in ENSEMBLES["cases"].pilots(Path(RESULTS)).values()]
WALLS = [f"{RESULTS}/walls/{name}.nc" for name, rock in ROCKS.items() if rock.walls]
CACHED = functools.cache(functools.partial(cached, CONFIGURED))


def keys_of(*kinds):
    """Digest of all that the joints of some kinds depend on."""
    return digest(*(entry.key for kind in kinds for entry in CACHED(kind).values()))


def closed_apart(*names):
    """Files of the cache that are jobs of a cluster, whose nodes see no process of this machine."""
    return [] if workflow.local_exec else [f"{RESULTS}/{name}.nc" for name in names]


def kernels_file(kind):
    """File of compiled kernels; its name has their digest, as a changed list must be a missing file:
    Snakemake plans only the maker of an ancient file that is there and was made with other parameters.
    """
    kind = kind.replace("effects_of", "cases")
    kernels = (ENSEMBLES | DESIGNS)[kind].kernels()
    return f"{RESULTS}/logs/{kind}_kernels_{digest(kernels)[:8]}.txt"
