"""Report of a study: summary, findings, tables, LaTeX, film and files for ParaView.

`summary`, `findings` and `tables` fill the HTML report, `latex` and `typeset` serve a paper,
`movie` writes the film, and `vtk` exports snapshots.
"""
