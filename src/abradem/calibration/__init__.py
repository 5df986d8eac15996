"""Search for the set-ups of a simulation that explain a table of wear rates.

`space` draws set-ups of what is unknown, `rows` arranges the rows of the table, `trials` simulates
them under a set-up, `agreement` compares simulated with given wear rates, `halving` decides which
set-ups get more rows and replicates, and `outcome` states what was found and what the search
cannot tell apart.
"""
