"""The verification study: the engine against exact results, other codes and itself.

Each module computes the tables of one question. `table` says how a table of checks is made and
judged, `scenes` sets the stage. Nothing here is used by a study of wear.
"""
