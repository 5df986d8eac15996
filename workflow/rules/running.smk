# Records of a run: configuration, versions, and the graph of the rules.
WORKFLOW_FILES = [
    Path(HOME, "Snakefile"),
    *sorted(Path(HOME, "workflow/rules").glob("*.smk")),
]
# For Snakemake when it draws the graph. JSON is YAML, whatever the table is called.
THE_TABLE = json.dumps(CONFIG.dataset.model_dump(mode="json"), ensure_ascii=False)
THE_TARGET = json.dumps({"target": CONFIG.learning.target})
GRAPH_OPTIONS = [
    *(["--configfile", file_of_workflow("config.yaml")] if IN_MODULE else []),
    *(
        []
        if SIMULATED
        else ["--config", f"dataset={THE_TABLE}", f"learning={THE_TARGET}"]
    ),
]


rule rule_graph:
    """The rules of the workflow and their dependencies."""
    output:
        f"{RESULTS}/rule_graph.parquet",
    log:
        f"{LOGS}/rule_graph.log",
    conda:
        "../envs/abradem.yaml"
    params:
        snakefile=verbatim(os.path.relpath(WORKFLOW_FILES[0])),
        rule_files=verbatim([os.path.relpath(path) for path in WORKFLOW_FILES[1:]]),
        options=verbatim(GRAPH_OPTIONS),
        rules=files_hash(*WORKFLOW_FILES),
        code=code_of("running/rule_graph"),
    script:
        "../scripts/running/rule_graph.py"


# No other rule depends on these files, so a change of machine or version reruns only this rule.
rule provenance:
    """The resolved configuration, versions, seed and code hashes of the run."""
    output:
        config=report(
            f"{RESULTS}/config.yaml",
            caption="../report/config.rst",
            category="Provenance",
            labels={"file": "config.yaml"},
        ),
        versions=report(
            f"{RESULTS}/versions.json",
            caption="../report/versions.rst",
            category="Provenance",
            labels={"file": "versions.json"},
        ),
    log:
        f"{LOGS}/provenance.log",
    conda:
        "../envs/abradem.yaml"
    params:
        config=verbatim(to_yaml(CONFIG)),
        # A function, so that it includes the rules that are defined later.
        recorded=lambda wildcards: {
            "seed": CONFIG.seed,
            "versions": versions(),
            "code": dict(sorted(CODE.items())),
        },
        code=code_of("running/provenance"),
    script:
        "../scripts/running/provenance.py"
