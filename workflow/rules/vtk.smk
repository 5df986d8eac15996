# On demand: snakemake vtk. The case that stands for the study, and those of simulation.export.
localrules:
    vtk,


rule vtk:
    """Target, on demand: particles and plate for ParaView."""
    input:
        f"{RESULTS}/vtk/typical",
        expand(f"{RESULTS}/vtk/case-{{case}}", case=CONFIG.simulation.export.cases),


rule vtk_of_scene:
    """Snapshots of a case for ParaView."""
    input:
        particles=f"{RESULTS}/scenes/{{scene}}/particles.parquet",
        wear=f"{RESULTS}/scenes/{{scene}}/wear.parquet",
    output:
        directory(f"{RESULTS}/vtk/{{scene}}"),
    log:
        f"{LOGS}/vtk/{{scene}}.log",
    wildcard_constraints:
        scene="|".join(map(re.escape, SCENES)),
    conda:
        "../envs/abradem.yaml"
    params:
        case=lambda wildcards: {**TYPICAL, **SCENES[wildcards.scene][0]},
        setup=SETUP,
        code=CODE["vtk"],
    script:
        "../scripts/vtk.py"


rule vtk_of_case:
    """Snapshots of a case for ParaView."""
    input:
        particles=rules.export.output.particles,
        wear=rules.export.output.wear,
        cases=lambda wildcards: shards_with(
            [int(wildcards.case)], f"{RESULTS}/cases/block-{{block}}.parquet"
        ),
    output:
        directory(f"{RESULTS}/vtk/case-{{case}}"),
    log:
        f"{LOGS}/vtk/case-{{case}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        case=None,
        setup=SETUP,
        code=CODE["vtk"],
    script:
        "../scripts/vtk.py"
