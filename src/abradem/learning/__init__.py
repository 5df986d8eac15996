"""Training and evaluation of wear models: protocols, scores, model files, comparison.

`baselines` holds the models of the paper, `physical` the physics-informed (dimensionless) models.
Under the leakage-free protocol everything that learns, scalers included, sees training rows only,
and all models are scored on the same held-out rows, which `protocols` draws.
"""
