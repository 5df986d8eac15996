# In the place of sampling, simulation and dataset: a table from elsewhere.
EXTERNAL = CONFIG.dataset.external

if not Path(EXTERNAL).is_file():
    sys.exit(f"dataset.external: {EXTERNAL}: there is no such file")


rule dataset:
    input:
        EXTERNAL,
    output:
        report(
            f"{RESULTS}/dataset.parquet",
            caption="../report/external.rst",
            category="Data",
            labels={"table": "data set"},
        ),
    log:
        f"{LOGS}/dataset.log",
    conda:
        "../envs/abradem.yaml"
    params:
        columns=CONFIG.dataset.columns,
        damping_coefficient=CONFIG.features.damping_coefficient,
        code=CODE["external"],
    script:
        "../scripts/external.py"
