"""The surrogate of a study: fast predictions of wear depth rates with intervals.

`groups` computes the dimensionless groups, `model` predicts, and `onnx` exports the surrogate for
use outside Python.
"""
