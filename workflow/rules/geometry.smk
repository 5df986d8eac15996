# The wear of a surface that is no plate: of its cells, of its named parts, and what decides it.
CELLS = f"{RESULTS}/cells.parquet"


localrules:
    surface,


rule surface:
    """Target: the wear of a surface by cell and by part, its figures, and the answer in words."""
    input:
        CELLS,
        f"{RESULTS}/parts.html",
        expand(
            f"{RESULTS}/figures/{{figure}}.{{suffix}}",
            figure=["setup", "surface", "part_rates"],
            suffix=FORMATS,
        ),
        f"{RESULTS}/scene.html",


rule cells:
    """The wear of every cell and of every named part of the surface of each case."""
    input:
        cases=CASES,
        maps=batch_paths(f"{RESULTS}/maps/block-{{block}}-batch-{{batch}}.parquet"),
        runs=RUNS,
    output:
        cells=report(
            CELLS,
            caption="../report/cells.rst",
            category="Data",
            labels={"table": "cells"},
        ),
        parts=report(
            f"{RESULTS}/wear_by_part.parquet",
            caption="../report/cells.rst",
            category="Data",
            labels={"table": "parts"},
        ),
    log:
        f"{LOGS}/cells.log",
    conda:
        "../envs/abradem.yaml"
    params:
        setup=SETUP,
        footprint_share=CONFIG.wear_rate.footprint_share,
        code=code_of("geometry/cells"),
    script:
        "../scripts/geometry/cells.py"


if CONFIG.learning.part is not None:

    rule part_rows:
        """The rows of the data set with the wear of the part that the models explain."""
        input:
            dataset=f"{RESULTS}/dataset.parquet",
            parts=rules.cells.output.parts,
        output:
            f"{RESULTS}/learning/part_rows.parquet",
        log:
            f"{LOGS}/part_rows.log",
        conda:
            "../envs/abradem.yaml"
        params:
            part=CONFIG.learning.part,
            code=code_of("geometry/part_rows"),
        script:
            "../scripts/geometry/part_rows.py"


rule part_effects:
    """What the quantities of the study do to the wear of each part, and the answer in words."""
    input:
        cases=CASES,
        parts=rules.cells.output.parts,
    output:
        table=f"{RESULTS}/part_effects.parquet",
        page=report(
            f"{RESULTS}/parts.html",
            caption="../report/parts.rst",
            category="Findings",
            labels={"page": "parts"},
        ),
    log:
        f"{LOGS}/part_effects.log",
    conda:
        "../envs/abradem.yaml"
    params:
        study=CONFIG.study,
        column=TARGET["name"],
        reference=CONFIG.wear_rate.reference_mm_s,
        source=CONFIG.wear_rate.reference_source,
        part=CONFIG.learning.part,
        code=code_of("geometry/answers"),
    script:
        "../scripts/geometry/answers.py"


rule figure_surface:
    """Wear map of the surface of a case."""
    input:
        cells=rules.cells.output.cells,
        cases=CASES,
    output:
        figure_files("surface"),
    log:
        f"{LOGS}/figure_surface.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("surface"),
        options={
            "setup": SETUP,
            "shown": CONFIG.figures.series_cases[0],
            "measure": MEASURE,
        },
    script:
        "../scripts/figures/figure.py"


rule figure_part_rates:
    """Wear of each part against the quantities that varied."""
    input:
        parts=rules.cells.output.parts,
        effects=rules.part_effects.output.table,
        cases=CASES,
    output:
        figure_files("part_rates"),
    log:
        f"{LOGS}/figure_part_rates.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("part_rates"),
        options={
            "target": TARGET,
            "reference": CONFIG.wear_rate.reference_mm_s,
            "source": CONFIG.wear_rate.reference_source,
        },
    script:
        "../scripts/figures/figure.py"
