"""What studies share: configuration, cases, products, tables, figures, jobs of the workflow."""
