"""The study of Rezaei Niya & Selvadurai: tables, claims, figures and report."""
