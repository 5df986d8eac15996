# What surrounds a run: its configuration and versions, and the graph of its rules.
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
        rules=files_hash(*WORKFLOW_FILES),
        code=code_of("running/rule_graph"),
    script:
        "../scripts/running/rule_graph.py"


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
        # Of all rules, also of those that are read later.
        recorded=lambda wildcards: {
            "seed": CONFIG.seed,
            "versions": versions(),
            "code": dict(sorted(CODE.items())),
        },
        code=code_of("running/provenance"),
    script:
        "../scripts/running/provenance.py"
