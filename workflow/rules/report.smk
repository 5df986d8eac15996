if not IN_MODULE:

    report: "../report/workflow.rst"


# Tables that the report shows, see abradem.report.tables. The Parquet files are the data.
TABLE_FILES = {
    "dataset": ROWS,
    "linear_coefficients": rules.linear.output.coefficients,
    "linear_published": rules.linear.output.published,
    "penalised_weights": rules.penalised.output.weights,
    "selection": rules.selection.output.selection,
    "scores": rules.scores.output.scores,
    "comparison": rules.scores.output.comparison,
    "beside_paper": rules.scores.output.beside_paper,
    "error_by_region": rules.scores.output.by_region,
    "power_law": rules.fit_physical.output.exponents,
    **({} if WEARS_SURFACE else {"exponents": rules.exponents.output[0]}),
    "targets": rules.reach.output.targets,
    "extrapolation": rules.reach.output.extrapolation,
    "sobol": rules.sensitivity.output.indices,
    "calibration": rules.intervals.output.calibration,
    "coverage": rules.intervals.output.regions,
    **({"fresh_coverage": rules.fresh_coverage.output.coverage} if TESTED_WITH else {}),
    **({"failures": rules.failures.output[0]} if SIMULATED else {}),
}


# Files from which the numbers of a text are read.
CITED = [
    "dataset.parquet",
    "summary.json",
    "learning/comparison.parquet",
    "learning/beside_paper.parquet",
    "learning/scores.parquet",
    "learning/selection.parquet",
    "learning/exponents.parquet",
    *(f"learning/ga_ann_{protocol}.json" for protocol in PROTOCOLS),
]
# Only the keys of the configuration that are cited, so that other keys do not change the tables.
CITED_KEYS = {
    "study": True,
    "seed": True,
    "sampling": True,
    "simulation": {"plate", "factory", "time_step_rayleigh_fraction", "stop"},
    "features": True,
    "learning": {"repeats", "test_share"},
}
IN_LATEX = ["numbers", "quantities", "features", "models", "exponents", "verification"]


localrules:
    documents,
    paper,


rule documents:
    """Target: overview, tables, findings, numbers for LaTeX, configuration and versions."""
    input:
        f"{RESULTS}/overview.html",
        expand(f"{RESULTS}/tables/{{table}}.csv", table=TABLE_FILES),
        f"{RESULTS}/models/findings.html",
        f"{RESULTS}/models/model_card.html",
        f"{RESULTS}/explorer.html",
        f"{RESULTS}/scene.html" if SIMULATED else [],
        f"{RESULTS}/config.yaml",
        f"{RESULTS}/versions.json",
        # Texts for a paper are about the plate.
        [] if WEARS_SURFACE else expand(f"{RESULTS}/latex/{{name}}.tex", name=IN_LATEX),


rule table:
    """A table as text, and as a page for the report."""
    input:
        table=lambda wildcards: TABLE_FILES[wildcards.table],
        template=TABLE_PAGE,
    output:
        text=f"{RESULTS}/tables/{{table}}.csv",
        page=report(
            f"{RESULTS}/tables/{{table}}.html",
            caption="../report/table.rst",
            category="Tables",
            labels={"table": "{table}"},
        ),
    log:
        f"{LOGS}/table/{{table}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        # Used by the report.
        caption=lambda wildcards: TABLES[wildcards.table],
        code=code_of("report/table"),
    script:
        "../scripts/report/table.py"


rule summary:
    """Headline numbers for the overview of the report."""
    input:
        dataset=ROWS,
        failures=rules.failures.output[0] if SIMULATED else [],
        linear=rules.linear.output.summary,
        comparison=rules.scores.output.comparison,
    output:
        SUMMARY,
    log:
        f"{LOGS}/summary.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "good_r2": CONFIG.wear_rate.good_r2,
            "external": CONFIG.dataset.external,
            **{name: TARGET[name] for name in ("element_size", "cells", "part")},
        },
        code=code_of("report/summary"),
    script:
        "../scripts/report/summary.py"


rule overview:
    """The first screen of the report, also a page of its own."""
    input:
        summary=rules.summary.output[0],
        comparison=rules.scores.output.comparison,
        noise=NOISE_SUMMARY,
        picture=f"{RESULTS}/figures/comparison.png",
        template=file_of_workflow("workflow/report/overview.html"),
    output:
        OVERVIEW,
    log:
        f"{LOGS}/overview.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "study": CONFIG.study,
            "confidence": LEARNING.confidence,
            "surface": WORN_SURFACE,
        },
        code=code_of("report/overview"),
    script:
        "../scripts/report/overview.py"


rule findings:
    """Findings of the models as text."""
    input:
        physical=rules.fit_physical.output.summary,
        intervals=rules.intervals.output.summary,
        surrogate=rules.surrogate.output.model,
        sensitivity=rules.sensitivity.output.summary,
        curve=rules.reach.output.curve,
        extrapolation=rules.reach.output.extrapolation,
        indices=rules.sensitivity.output.indices,
        falls=rules.sensitivity.output.falls,
        exponents=[] if WEARS_SURFACE else rules.exponents.output[0],
        comparison=rules.scores.output.comparison,
        by_region=rules.scores.output.by_region,
        fresh=FRESH_SUMMARY[0] if TESTED_WITH else [],
        noise=NOISE_SUMMARY,
        speed=rules.speed_up.output[0] if ON_PLATE else [],
    output:
        report(
            f"{RESULTS}/models/findings.html",
            caption="../report/findings.rst",
            category="Models",
            labels={"file": "findings.html", "content": "findings in words"},
        ),
    log:
        f"{LOGS}/findings.log",
    conda:
        "../envs/abradem.yaml"
    params:
        table=CONFIG.study,
        target=TARGET if TARGET["known"] else None,
        code=code_of("report/findings"),
    script:
        "../scripts/report/findings.py"


rule model_card:
    """Use, jet, targets, ranges, scores and coverage of the surrogate."""
    input:
        surrogate=rules.surrogate.output.model,
        intervals=rules.intervals.output.summary,
        regions=rules.intervals.output.regions,
        fresh=FRESH_SUMMARY[0] if TESTED_WITH else [],
        failures=FAILURES if SIMULATED else [],
    output:
        card=f"{RESULTS}/models/model_card.json",
        page=report(
            f"{RESULTS}/models/model_card.html",
            caption="../report/model_card.rst",
            category="Models",
            labels={
                "file": "model_card.html",
                "content": "model card of the surrogate",
            },
        ),
    log:
        f"{LOGS}/model_card.log",
    conda:
        "../envs/abradem.yaml"
    params:
        said={
            "ranges": (
                {**sampled_ranges(CONFIG), **geometry_ranges(CONFIG)}
                if SIMULATED
                else None
            ),
            "software": abradem.__version__,
            "licence": LICENCE if SIMULATED else None,
            "confidence": LEARNING.confidence,
        },
        code=code_of("report/model_card"),
    script:
        "../scripts/report/model_card.py"


rule explorer:
    """The explorer, a page that predicts wear while sliders are moved."""
    input:
        dataset=ROWS,
        model=rules.surrogate.output.model,
        model_arrays=rules.surrogate.output.model_arrays,
        maps=rules.wear_maps.output.model if ON_PLATE else [],
        map_arrays=rules.wear_maps.output.model_arrays if ON_PLATE else [],
    output:
        report(
            f"{RESULTS}/explorer.html",
            caption="../report/explorer.rst",
            category="Models",
            labels={"file": "explorer.html", "content": "explorer"},
        ),
    log:
        f"{LOGS}/explorer.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "study": CONFIG.study,
            "presets": {name: preset(name) for name in PARTICLE_MATERIALS},
        },
        # The parts of the page are no modules.
        parts=files_hash(*FRAME_FILES, *EXPLORER_FILES),
        code=code_of("report/explorer"),
    script:
        "../scripts/report/explorer.py"


rule latex:
    """Target: tables and numbers for a LaTeX text."""
    input:
        expand(f"{RESULTS}/{{file}}", file=CITED),
    output:
        **{name: latex_file(name) for name in IN_LATEX},
    log:
        f"{LOGS}/latex.log",
    conda:
        "../envs/abradem.yaml"
    params:
        study=CONFIG.study,
        config=CONFIG.model_dump(mode="json", include=CITED_KEYS),
        names=CITED + (["../verification/checks.parquet"] if VERIFICATION_MADE else []),
        files=lambda wildcards, input: [
            *input,
            *([str(VERIFICATION_CHECKS)] if VERIFICATION_MADE else []),
        ],
        verification=files_hash(VERIFICATION_CHECKS) if VERIFICATION_MADE else None,
        code=code_of("report/latex"),
    script:
        "../scripts/report/latex.py"


# On demand, as it needs LaTeX: `snakemake paper`.
rule paper:
    """Target, on demand: the example paper as PDF; needs LaTeX."""
    input:
        f"{RESULTS}/paper.pdf",


rule paper_pdf:
    """The example paper with the tables, numbers and figures of a study."""
    input:
        text=file_of_workflow("paper/main.tex"),
        included=rules.latex.output,
        figures=expand(
            f"{RESULTS}/figures/{{name}}.pdf",
            name=[
                *(["setup", "generation", "angles", "maps"] if SIMULATED else []),
                "coefficients",
                "comparison",
                "architecture",
            ],
        ),
    output:
        f"{RESULTS}/paper.pdf",
    log:
        f"{LOGS}/paper_pdf.log",
    conda:
        "../envs/abradem.yaml"
    params:
        folder=lambda wildcards, output: os.path.dirname(output[0]),
        code=code_of("report/typeset"),
    script:
        "../scripts/report/typeset.py"
