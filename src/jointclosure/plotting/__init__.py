"""Figures: datasets and tables in, figures out; no files, no computing of what a study means."""

from jointclosure.extras import needs

with needs("figures", "a figure"):
    import matplotlib

    matplotlib.use("Agg")

    import seaborn as sns

sns.set_theme(context="paper", style="ticks", palette="colorblind", font_scale=1.1)
matplotlib.rcParams.update({"figure.dpi": 150, "savefig.dpi": 150, "axes.grid": False})
