"""The verification study: the engine compared with exact results, other codes and itself.

Most modules compute the tables of one part of the study. `checks` defines a check, its verdict and
the tables of checks; `scenes` defines materials and set-ups. Wear studies use nothing of this
package.
"""
