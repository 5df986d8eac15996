"""Models of the paper, each under both protocols: linear, penalised, PCA, trees, GA-ANN.

`selection` chooses the features of the networks, `genetic` searches for their architecture, and
`ga_ann` trains and scores them.
"""
