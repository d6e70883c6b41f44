"""Figures: datasets and tables in, figures out; no files, no computing of what a study means."""
