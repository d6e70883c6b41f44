"""Figures: datasets and tables in, figures out; no files, no computing of what a study means."""

from jointclosure.inputs.extras import needs

with needs("figures", "a figure"):
    import matplotlib as _  # noqa: F401
    import seaborn as __  # noqa: F401
