# Pictures of short simulations: the set-up, the scene in 3-D, the film and files for ParaView, of
# the plate and of any other geometry.
localrules:
    movie,
    vtk,


rule figure_setup:
    """The simulation set-up: plate or geometry, factory, particles and wear."""
    input:
        particles=f"{RESULTS}/scenes/typical/particles.parquet",
        wear=f"{RESULTS}/scenes/typical/wear.parquet",
    output:
        figure_files("setup"),
    log:
        f"{LOGS}/figure_setup.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("setup"),
        options={"case": TYPICAL, "setup": SETUP, "measure": MEASURE},
    script:
        "../scripts/figures/figure.py"


rule scene_page:
    """Particles and wear of the typical case in three dimensions, as a page."""
    input:
        particles=f"{RESULTS}/scenes/typical/particles.parquet",
        wear=f"{RESULTS}/scenes/typical/wear.parquet",
    output:
        report(
            f"{RESULTS}/scene.html",
            caption="../report/scene.rst",
            category="Set-up",
            labels={"file": "scene.html", "content": "scene in 3-D"},
        ),
    log:
        f"{LOGS}/scene_page.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "study": CONFIG.study,
            "case": TYPICAL,
            "setup": SETUP,
            "measure": MEASURE,
        },
        # The parts of the page are no modules.
        parts=files_hash(*FRAME_FILES, *SCENE_FILES),
        code=code_of("report/scene"),
    script:
        "../scripts/report/scene.py"


# On demand: `snakemake movie`; needs an encoder, pip install -e '.[movie]'.


rule movie:
    """Target, on demand: a film of the growing wear; needs the extra movie."""
    input:
        f"{RESULTS}/movie/wear.mp4",
        f"{RESULTS}/movie/wear.png",


rule film:
    """The film of plates side by side, or of the geometry, and its last frame."""
    input:
        particles=expand(rules.scene.output.particles, scene=FILMED),
        wear=expand(rules.scene.output.wear, scene=FILMED),
    output:
        film=f"{RESULTS}/movie/wear.mp4",
        still=f"{RESULTS}/movie/wear.png",
    log:
        f"{LOGS}/film.log",
    conda:
        "../envs/abradem.yaml"
    params:
        cases=[{**TYPICAL, **SCENES[scene][0]} for scene in FILMED],
        setup=SETUP,
        measure=MEASURE,
        width=FILM.panel_pixels,
        per_second=FILM.frames_per_second,
        code=code_of("report/movie"),
    script:
        "../scripts/report/movie.py"


# On demand: `snakemake vtk`, for the typical case and the cases of simulation.export.


rule vtk:
    """Target, on demand: particles and plate for ParaView."""
    input:
        f"{RESULTS}/vtk/typical",
        expand(f"{RESULTS}/vtk/case-{{case}}", case=CONFIG.simulation.export.cases),


rule vtk_of_scene:
    """Snapshots of a scene for ParaView."""
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
        code=code_of("report/vtk"),
    script:
        "../scripts/report/vtk.py"


rule vtk_of_case:
    """Snapshots of a case for ParaView."""
    input:
        particles=rules.snapshots_of_case.output.particles,
        wear=rules.snapshots_of_case.output.wear,
        cases=lambda wildcards: batches_with(
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
        code=code_of("report/vtk"),
    script:
        "../scripts/report/vtk.py"
