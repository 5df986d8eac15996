"""Publication-quality figures: functions that take result tables and return matplotlib Figures.

`catalogue` lists the figures of a study, `style` defines their common appearance and saves them,
and `render` draws particles and plate. The other modules hold the functions that draw.
"""

from abradem.figures import before_matplotlib as before_matplotlib
