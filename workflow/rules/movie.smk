# On demand: snakemake movie. Needs an encoder, pip install -e '.[movie]'.
FILMED = [f"plate_{angle:g}" for angle in FILM.plate_angles]


localrules:
    movie,


rule movie:
    """Target, on demand: a film of wear growing on plates; needs the extra movie."""
    input:
        f"{RESULTS}/movie/wear.mp4",
        f"{RESULTS}/movie/wear.png",


rule film:
    """The film of plates side by side, and its last picture."""
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
        width=FILM.panel_pixels,
        per_second=FILM.frames_per_second,
        code=CODE["movie"],
    script:
        "../scripts/movie.py"
