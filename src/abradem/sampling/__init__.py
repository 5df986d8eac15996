"""The parameter sets of a study, what they must satisfy, and a guess of what they cost."""
