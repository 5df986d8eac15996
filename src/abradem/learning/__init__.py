"""Models of wear: protocols of evaluation, scores, and one module per family of models.

Whatever learns (a scaler included) sees training rows only, and all models are scored on the
same held-out rows, from `protocols`.
"""
