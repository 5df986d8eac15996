"""The parameter sets of a study, their physical checks, and an estimate of their computing time."""
