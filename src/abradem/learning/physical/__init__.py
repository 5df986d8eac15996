"""Physics-informed models: regression on dimensionless groups, and the analysis of the results.

`problem` defines the regression problem, `models` fits and scores the four models (`power_law`,
`gaussian_process`, and boosting and networks in `ensembles`). `intervals`, `sensitivity`, `reach`
and `noise_floor` analyse them, `distil` makes the surrogate, and `speed_up` times it.
"""
