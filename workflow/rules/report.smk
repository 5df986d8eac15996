if not IN_MODULE:

    report: "../report/workflow.rst"


# Tables that the report offers for reading; the Parquet files stay the data.
TABLES = {
    "linear_coefficients": rules.linear.output.coefficients,
    "linear_published": rules.linear.output.published,
    "penalised_weights": rules.penalised.output.weights,
    "selection": rules.selection.output.selection,
    "scores": rules.scores.output.scores,
    "comparison": rules.scores.output.comparison,
    "beside_paper": rules.scores.output.beside_paper,
    "power_law": rules.physical.output.exponents,
    "targets": rules.reach.output.targets,
    "extrapolation": rules.reach.output.extrapolation,
    "sobol": rules.sensitivity.output.indices,
    "calibration": rules.intervals.output.calibration,
    **({"failures": rules.failures.output} if SIMULATED else {}),
}


localrules:
    documents,


rule documents:
    """Target: tables, numbers for LaTeX, configuration and versions."""
    input:
        expand(f"{RESULTS}/tables/{{table}}.csv", table=TABLES),
        f"{RESULTS}/summary.json",
        f"{RESULTS}/config.yaml",
        f"{RESULTS}/versions.json",
        expand(f"{RESULTS}/latex/{{name}}.tex", name=IN_LATEX),


rule table:
    """A table as text, for reading."""
    input:
        lambda wildcards: TABLES[wildcards.table],
    output:
        report(
            f"{RESULTS}/tables/{{table}}.csv",
            caption="../report/table.rst",
            category="Tables",
            labels={"table": "{table}"},
        ),
    log:
        f"{LOGS}/table/{{table}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        code=CODE["table"],
    script:
        "../scripts/table.py"


rule summary:
    """The numbers that the report's overview begins with."""
    input:
        dataset=rules.dataset.output[0],
        failures=rules.failures.output[0] if SIMULATED else [],
        model=rules.linear.output.summary,
        comparison=rules.scores.output.comparison,
    output:
        SUMMARY,
    log:
        f"{LOGS}/summary.log",
    conda:
        "../envs/abradem.yaml"
    params:
        good_r2=CONFIG.wear_rate.good_r2,
        external=CONFIG.dataset.external,
        code=CODE["summary"],
    script:
        "../scripts/summary.py"


# Nothing depends on these files, so another machine or another version reruns only this.
rule provenance:
    """The resolved configuration, and what else identifies the run."""
    output:
        config=report(
            f"{RESULTS}/config.yaml",
            caption="../report/config.rst",
            category="Provenance",
            labels={"file": "resolved configuration"},
        ),
        versions=report(
            f"{RESULTS}/versions.json",
            caption="../report/versions.rst",
            category="Provenance",
            labels={"file": "versions and seed"},
        ),
    log:
        f"{LOGS}/provenance.log",
    conda:
        "../envs/abradem.yaml"
    params:
        config=to_yaml(CONFIG),
        recorded={"seed": CONFIG.seed, "versions": versions(), "code": CODE},
        code=CODE["provenance"],
    script:
        "../scripts/provenance.py"
