"""Public names, which `lazy_loader` and type checkers read here."""

from .assessment.assess import assess as assess
from .assessment.effect_selection import choose_effects as choose_effects
from .ensembles.simulation import simulate_ensemble as simulate_ensemble
from .inputs.checks import InputError as InputError
from .joint.conditions import Conditions as Conditions
from .joint.simulation import equilibrium as equilibrium
from .joint.simulation import simulate as simulate
from .measured.fit import fit as fit
from .measured.validation import validate as validate
from .parameters import Choices as Choices
from .parameters import Effects as Effects
from .parameters import Numerics as Numerics
from .parameters import Rock as Rock
from .plotting import plot as plot
from .statistics.indifference import indifference_interval as indifference_interval
from .uncertainty.scanned_joint import close as close
from .walls.scans import read_scan as read_scan
from .walls.synthesis import wall_pair as wall_pair

__version__: str
