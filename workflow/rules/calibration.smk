# A search for the set-ups that explain a table, instead of a study. Each trial of each rung is a
# job; the trials of a rung are the best of the rung before.
if not IN_MODULE:

    report: "../report/calibration_overview.rst"


from abradem.running.given_tables import calibration_inputs
from abradem.running.trial_setups import search_rungs
from abradem.store.files import TableError

SEARCH = CONFIG.calibration
JUDGED_BY = "log_r2_constant" if SEARCH.constant else "log_r2"
FOUND = f"{RESULTS}/calibration"
try:
    # Checked before anything is written; the rule reads the table again.
    CALIBRATION_TABLE, TRIALS, TRIAL_SETUPS = calibration_inputs(CONFIG, *origins())
except (ConfigError, TableError) as error:
    sys.exit(str(error))
RUNGS = search_rungs(CONFIG)


def runs_of_rung(rung):
    """Files of the trials of a rung."""
    return [
        f"{FOUND}/rung-{rung}/place-{place:04d}.parquet"
        for place in range(RUNGS[rung].trials)
    ]


def scores_before(wildcards):
    """The scores of the rung before, from which the trials of a rung are chosen."""
    rung = int(wildcards.rung)
    return {"scores": f"{FOUND}/rung-{rung - 1}/scores.parquet"} if rung else {}


wildcard_constraints:
    rung=r"\d+",
    place=r"\d+",


localrules:
    calibration,
    chosen_trials,


rule calibration:
    """Target: the set-ups that explain the table of calibration.table."""
    input:
        f"{FOUND}/calibration.html",
        f"{FOUND}/best.yaml",
        f"{FOUND}/trials.csv",
        expand(
            f"{RESULTS}/figures/{{figure}}.{{suffix}}",
            figure=["agreement", "profiles"],
            suffix=FORMATS,
        ),


rule trial_setups:
    """The set-ups of all trials, and the rows of the table in the order of the search."""
    output:
        setups=f"{FOUND}/setups.json",
        rows=f"{FOUND}/rows.parquet",
    log:
        f"{LOGS}/trial_setups.log",
    conda:
        "../envs/abradem.yaml"
    params:
        # No input, as braces in a path cannot be escaped; the content decides.
        table=verbatim(CALIBRATION_TABLE),
        content=files_hash(CALIBRATION_TABLE),
        columns=SEARCH.columns,
        rows={
            "target": SEARCH.target,
            "every": SEARCH.held_out_every,
            "least_radius": SEARCH.least_radius_mm / 1000.0,
            "leave_out": SEARCH.leave_out,
        },
        trials=TRIALS,
        setups=TRIAL_SETUPS,
        code=code_of("calibration/setups"),
    script:
        "../scripts/calibration/setups.py"


rule chosen_trials:
    """The trials of a rung: all, or the best of the rung before."""
    input:
        unpack(scores_before),
        setups=rules.trial_setups.output.setups,
    output:
        f"{FOUND}/rung-{{rung}}/chosen.json",
    log:
        f"{LOGS}/chosen_trials-{{rung}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        by=JUDGED_BY,
        trials=lambda wildcards: RUNGS[int(wildcards.rung)].trials,
        code=code_of("calibration/chosen"),
    script:
        "../scripts/calibration/chosen.py"


rule trial:
    """Rows of the table simulated under one set-up."""
    input:
        chosen=rules.chosen_trials.output[0],
        setups=rules.trial_setups.output.setups,
        rows=rules.trial_setups.output.rows,
    output:
        f"{FOUND}/rung-{{rung}}/place-{{place}}.parquet",
    log:
        f"{LOGS}/trials/rung-{{rung}}-place-{{place}}.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(BATCH_MB),
        runtime=growing(BATCH_MINUTES),
    params:
        options=lambda wildcards: {
            "place": int(wildcards.place),
            "count": RUNGS[int(wildcards.rung)].rows,
            "replicates": RUNGS[int(wildcards.rung)].replicates,
            "held_out": int(wildcards.rung) == len(RUNGS) - 1,
            "element_sizes": [size / 1000.0 for size in SEARCH.element_sizes_mm],
            "footprint_share": CONFIG.wear_rate.footprint_share,
        },
        code=code_of("calibration/trial"),
    script:
        "../scripts/calibration/trial.py"


rule trial_scores:
    """The agreement of the trials of a rung with the table."""
    input:
        rows=rules.trial_setups.output.rows,
        runs=lambda wildcards: runs_of_rung(int(wildcards.rung)),
    output:
        f"{FOUND}/rung-{{rung}}/scores.parquet",
    log:
        f"{LOGS}/trial_scores-{{rung}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        code=code_of("calibration/scores"),
    script:
        "../scripts/calibration/scores.py"


rule best_trial:
    """The best set-up, and what the search cannot tell apart."""
    input:
        setups=rules.trial_setups.output.setups,
        rows=rules.trial_setups.output.rows,
        scores=[f"{FOUND}/rung-{rung}/scores.parquet" for rung in range(len(RUNGS))],
        runs=runs_of_rung(len(RUNGS) - 1),
    output:
        summary=f"{FOUND}/summary.json",
        predicted=f"{FOUND}/predicted.parquet",
        slopes=f"{FOUND}/slopes.parquet",
        profiles=f"{FOUND}/profiles.parquet",
        trials=f"{FOUND}/trials.parquet",
    log:
        f"{LOGS}/best_trial.log",
    conda:
        "../envs/abradem.yaml"
    params:
        search=SEARCH.search,
        by=JUDGED_BY,
        code=code_of("calibration/best_trial"),
    script:
        "../scripts/calibration/best_trial.py"


rule trial_table:
    """The table of trials as text, and as a page for the report."""
    input:
        table=rules.best_trial.output.trials,
        template=TABLE_PAGE,
    output:
        text=f"{FOUND}/trials.csv",
        page=report(
            f"{FOUND}/trials.html",
            caption="../report/table.rst",
            category="Calibration",
            labels={"table": "trials"},
        ),
    log:
        f"{LOGS}/trial_table.log",
    conda:
        "../envs/abradem.yaml"
    params:
        caption="All set-ups with the last rung that they reached, their best reading (measure, "
        "statistic, element size) and its agreement with the table.",
        code=code_of("report/table"),
    script:
        "../scripts/report/table.py"


rule calibration_page:
    """The calibration in words, and the best set-up as an override file."""
    input:
        summary=rules.best_trial.output.summary,
        slopes=rules.best_trial.output.slopes,
        profiles=rules.best_trial.output.profiles,
    output:
        page=report(
            f"{FOUND}/calibration.html",
            caption="../report/calibration.rst",
            category="Calibration",
            labels={"table": "calibration"},
        ),
        best=f"{FOUND}/best.yaml",
    log:
        f"{LOGS}/calibration_page.log",
    conda:
        "../envs/abradem.yaml"
    params:
        config=CONFIG.model_dump(mode="json"),
        code=code_of("calibration/page"),
    script:
        "../scripts/calibration/page.py"


rule figure_agreement:
    """Simulated against given wear rates."""
    input:
        predicted=rules.best_trial.output.predicted,
        summary=rules.best_trial.output.summary,
        slopes=rules.best_trial.output.slopes,
    output:
        figure_files("agreement"),
    log:
        f"{LOGS}/figure_agreement.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("agreement"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_profiles:
    """The best score for each value of each unknown."""
    input:
        profiles=rules.best_trial.output.profiles,
        summary=rules.best_trial.output.summary,
    output:
        figure_files("profiles"),
    log:
        f"{LOGS}/figure_profiles.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("profiles"),
        options={},
    script:
        "../scripts/figures/figure.py"
