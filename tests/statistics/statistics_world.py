"""A world in which the truth is known: closures on surfaces, against one parameter."""

import numpy as np

from jointclosure.statistics.repetitions import Pool, Sensitivity

LEVELS = np.array([-1.0, 0.0, 1.0])
SCATTER = 0.15
TARGETS = 2


def closures(random, effect, count):
    """Closures (targets, count) at a level; skewed, and the two targets go together."""
    common = random.normal(size=count)
    own = random.normal(size=(TARGETS, count))
    slopes = np.array([[1.0], [-0.5]]) * effect
    return (1.0 + slopes) * np.exp(SCATTER * (0.6 * common + 0.8 * own))


def sensitivity(random, effect, pool, label, common=False):
    """A parameter of one rock with a pool of independent or common surfaces per level."""
    state = random.bit_generator.state
    pools = []
    for level in LEVELS:
        if common:
            random.bit_generator.state = state
        values = closures(random, effect * level, pool)
        pools.append(Pool(values, label if common else f"{label} {level}"))
    return Sensitivity(LEVELS, 0.0, tuple(pools))


def published(random, effects, draws=20):
    """Means and deviations (parameters, targets, levels) of one study of independent draws.

    The parameters share the draws at the base level.
    """
    at_base = closures(random, 0.0, draws)
    samples = np.array(
        [[closures(random, -e, draws), at_base, closures(random, e, draws)] for e in effects]
    )
    samples = np.moveaxis(samples, 1, 2)
    return samples.mean(axis=-1), samples.std(axis=-1, ddof=1)


def table_of(drawn):
    """All lengths of drawn studies (R, entries), with targets in the order of keys."""
    return np.concatenate([response.lengths for response in drawn.values()], axis=1)
