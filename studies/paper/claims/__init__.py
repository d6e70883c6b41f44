"""Claims of the paper, in one table, and their judgement.

`table` contains the claims: number, text, source in the paper, and statement. `statements` defines
what a statement means: margins, which are numbers of a model that are large if it is true, and
criteria by which a study confirms it, as in the paper. `findings` contains results of studies.
"""
