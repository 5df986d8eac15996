# On demand: `snakemake publish` builds a folder ready for an archive.
localrules:
    publish,


rule publish:
    """Target, on demand: a folder ready for an archive."""
    input:
        f"{RESULTS}/publish/ro-crate-metadata.json",


# The inputs have no names: Snakemake would hash a named list once for each of its files.
rule published_folder:
    """The published folder with data, data card, descriptors, figures and models."""
    input:
        CASES,
        FAILURES,
        rules.dataset.output,
        rules.provenance.output,
        rules.summary.output,
        rules.figures.input,
        expand(rules.table.output.text, table=TABLE_FILES),
        rules.linear.output,
        rules.penalised.output,
        rules.pca.output,
        rules.selection.output,
        rules.trees.output,
        expand(rules.ga_ann.output, protocol=PROTOCOLS),
        rules.scores.output,
        rules.exponents.output,
        rules.fit_physical.output,
        rules.intervals.output,
        rules.surrogate.output,
        rules.sensitivity.output,
        rules.reach.output,
        rules.wear_maps.output,
        rules.noise_floor.output,
        rules.findings.output,
        rules.model_card.output,
        (
            [
                *batch_paths(rules.simulate.output.series),
                *batch_paths(rules.simulate.output.maps),
                *RUNS,
            ]
            if CONFIG.publish.series
            else []
        ),
    output:
        f"{RESULTS}/publish/ro-crate-metadata.json",
        f"{RESULTS}/publish/croissant.json",
        f"{RESULTS}/publish/README.md",
    log:
        f"{LOGS}/publish.log",
    conda:
        "../envs/abradem.yaml"
    params:
        study={
            "name": CONFIG.study,
            "config": CONFIG.model_dump(mode="json"),
            "setup": SETUP,
            "said": CONFIG.publish.model_dump(),
        },
        code=code_of("publish/publish"),
    script:
        "../scripts/publish/publish.py"
