"""Statistics of a sensitivity study, Eqs. (24) to (29), independent of mechanics.

`indifference` computes the intervals of one study, unpaired and paired, with their bootstrap.
`standard_errors` (with confidence limits) and `control_variates` estimate the precision of means.
`repetitions` simulates what repetitions of a study would publish, and tests whether a published
table is one of them. `verdicts` judges claims.
"""
