# What a paper needs beside the figures of data and models: flow charts, the found networks,
# distributions, and what the verification study says where it was made.
WORKFLOW_FILES = [
    Path(HOME, "Snakefile"),
    *sorted(Path(HOME, "workflow/rules").glob("*.smk")),
]


rule rule_graph:
    """The rules of the workflow and what each takes from which."""
    output:
        f"{RESULTS}/rule_graph.parquet",
    log:
        f"{LOGS}/rule_graph.log",
    conda:
        "../envs/abradem.yaml"
    params:
        snakefile=os.path.relpath(WORKFLOW_FILES[0]),
        rule_files=[os.path.relpath(path) for path in WORKFLOW_FILES[1:]],
        options=[
            *(["--configfile", file_of_workflow("config.yaml")] if IN_MODULE else []),
            *(
                []
                if SIMULATED
                else ["--config", f"dataset={{external: {CONFIG.dataset.external}}}"]
            ),
        ],
        rules=code_hash([], *WORKFLOW_FILES),
        code=CODE["rule_graph"],
    script:
        "../scripts/rule_graph.py"


rule figure_flow:
    """Flow charts: generation of the data, set-up of a simulation, the whole workflow."""
    input:
        rules.rule_graph.output,
    output:
        generation=figure_files("generation", "generation of the data"),
        rules=figure_files("rules", "rules of the workflow"),
    log:
        f"{LOGS}/figure_flow.log",
    conda:
        "../envs/abradem.yaml"
    params:
        study={
            "cases": CONFIG.cases,
            "blocks": CONFIG.sampling.blocks,
            "jobs": CONFIG.jobs,
            "method": CONFIG.sampling.method,
            "seed": CONFIG.seed,
            "external": CONFIG.dataset.external,
        },
        setup=SETUP if SIMULATED else None,
        formats=FORMATS,
        code=CODE["figure_flow"],
    script:
        "../scripts/figure_flow.py"


rule figure_architecture:
    """The networks that the genetic search found."""
    input:
        expand(rules.ga_ann.output.summary, protocol=PROTOCOLS),
    output:
        figure_files("architecture", "found networks"),
    log:
        f"{LOGS}/figure_architecture.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_architecture"],
    script:
        "../scripts/figure_architecture.py"


rule figure_distributions:
    """Distributions of standardised wear, predictions and errors."""
    input:
        dataset=rules.dataset.output[0],
        predictions=rules.scores.output.predictions,
    output:
        figure_files("distributions", "distributions of wear and errors"),
    log:
        f"{LOGS}/figure_distributions.log",
    conda:
        "../envs/abradem.yaml"
    params:
        target=LEARNING.target,
        model="ga_ann",
        formats=FORMATS,
        code=CODE["figure_distributions"],
    script:
        "../scripts/figure_distributions.py"


if VERIFICATION_MADE:

    # Not an input: a study shows what `make verify` found last, and does not make it anew.
    rule figure_verification:
        """The verification study at a glance."""
        output:
            figure_files("verification", "verification"),
        log:
            f"{LOGS}/figure_verification.log",
        conda:
            "../envs/abradem.yaml"
        params:
            checks=str(VERIFICATION_CHECKS),
            content=code_hash([], VERIFICATION_CHECKS),
            formats=FORMATS,
            code=CODE["figure_verification"],
        script:
            "../scripts/figure_verification.py"


if SPEED_MADE:

    rule figure_speed:
        """What simulations cost."""
        output:
            figure_files("speed", "speed of the engine"),
        log:
            f"{LOGS}/figure_speed.log",
        conda:
            "../envs/abradem.yaml"
        params:
            tables=[str(path) for path in SPEED_TABLES],
            content=code_hash([], *SPEED_TABLES),
            formats=FORMATS,
            code=CODE["figure_speed"],
        script:
            "../scripts/figure_speed.py"


# Files that numbers of a text are read from.
CITED = [
    "dataset.parquet",
    "summary.json",
    "learning/comparison.parquet",
    "learning/beside_paper.parquet",
    "learning/scores.parquet",
    "learning/selection.parquet",
    *(f"learning/ga_ann_{protocol}.json" for protocol in PROTOCOLS),
]
# Of the configuration only what is cited, so that other keys leave the tables as they are.
CITED_KEYS = {
    "study": True,
    "seed": True,
    "sampling": True,
    "simulation": {"plate", "factory", "time_step_rayleigh_fraction", "stop"},
    "features": True,
    "learning": {"repeats", "test_share"},
}
IN_LATEX = ["numbers", "quantities", "features", "models", "verification"]


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
        verification=code_hash([], VERIFICATION_CHECKS) if VERIFICATION_MADE else None,
        code=CODE["latex"],
    script:
        "../scripts/latex.py"


localrules:
    paper,


# On demand, as it needs a LaTeX: snakemake paper.
rule paper:
    """Target, on demand: the example text as PDF; needs a LaTeX."""
    input:
        f"{RESULTS}/paper.pdf",


rule paper_pdf:
    """The example text with the tables, numbers and figures of a study, as PDF."""
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
        code=CODE["paper"],
    script:
        "../scripts/paper.py"
