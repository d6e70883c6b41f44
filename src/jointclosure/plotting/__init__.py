"""Figures from datasets and tables; they read no files and compute no results of a study."""

from jointclosure.inputs.extras import needs

with needs("figures", "a figure"):
    import matplotlib as _  # noqa: F401
    import seaborn as __  # noqa: F401
