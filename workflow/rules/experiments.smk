# Experiments: sections of the configuration, each with a folder of `studies`. Its `study.py` states
# the points at which joints are simulated, tables of the joints, and figures of the tables.
rule close_points:
    input:
        kernels=lambda w: kernel_files(POINTS[w.experiment]()[w.job]),
    output:
        f"{RESULTS}/{{experiment}}/{{job}}.nc",
    log:
        f"{RESULTS}/logs/close_points/{{experiment}}/{{job}}.log",
    wildcard_constraints:
        experiment="|".join(EXPERIMENTS) or "none",
    group:
        "closures"
    conda:
        ENVIRONMENT
    params:
        points=lambda w: POINTS[w.experiment]()[w.job],
        quantities=lambda w: EXPERIMENTS[w.experiment].quantities,
        key=lambda w: points_key(w.experiment, w.job),
        code=lambda w: code(
            "close_points.py", *makers(w.experiment, w.job), titles=False
        ),
    message:
        "Simulate the joints of {wildcards.experiment}, {wildcards.job}"
    script:
        "../scripts/close_points.py"


rule tabulate_experiment:
    input:
        lambda w: collect(
            f"{RESULTS}/{{experiment}}/{{job}}.nc",
            experiment=TABLE_OF[w.table],
            job=POINTS[TABLE_OF[w.table]](),
        ),
    output:
        f"{RESULTS}/tables/{{table}}",
    log:
        f"{RESULTS}/logs/tabulate_experiment/{{table}}.log",
    wildcard_constraints:
        table="|".join(TABLE_OF) or "none",
    conda:
        ENVIRONMENT
    params:
        experiment=lambda w: TABLE_OF[w.table],
        # keys of the files, in their order
        keys_of_jobs=lambda w: [
            points_key(TABLE_OF[w.table], job) for job in POINTS[TABLE_OF[w.table]]()
        ],
        settings=lambda w: EXPERIMENTS[TABLE_OF[w.table]].settings(STUDY),
        code=lambda w: code(
            "tabulate_experiment.py",
            name_of(EXPERIMENTS[TABLE_OF[w.table]].tables[w.table]),
        ),
    message:
        "Tabulate {wildcards.table}"
    script:
        "../scripts/tabulate_experiment.py"


rule draw_experiment:
    input:
        lambda w: collect(
            f"{RESULTS}/tables/{{table}}",
            table=[
                table
                for table in EXPERIMENTS[FIGURE_OF[w.figure]].tables
                if table.endswith(".csv")
            ],
        ),
    output:
        report(
            f"{RESULTS}/figures/{{figure}}.png",
            caption="../report/experiment.rst",
            category="Figures of experiments",
            labels={"figure": "{figure}"},
        ),
        f"{RESULTS}/figures/{{figure}}.pdf",
    log:
        f"{RESULTS}/logs/draw_experiment/{{figure}}.log",
    wildcard_constraints:
        figure="|".join(FIGURE_OF) or "none",
    conda:
        ENVIRONMENT
    params:
        experiment=lambda w: FIGURE_OF[w.figure],
        settings=lambda w: EXPERIMENTS[FIGURE_OF[w.figure]].settings(STUDY),
        code=lambda w: code(
            "draw_experiment.py",
            name_of(EXPERIMENTS[FIGURE_OF[w.figure]].figures[w.figure]),
        ),
    message:
        "Draw {wildcards.figure}"
    script:
        "../scripts/draw_experiment.py"


rule estimate_experiment:
    input:
        kernels=lambda w: kernel_files(points_estimated(w.experiment)),
        scanned=lambda w: [
            surfaces for surfaces, _ in scans_estimated(w.experiment).values()
        ],
    output:
        f"{RESULTS}/tables/{{experiment}}_estimate.csv",
    log:
        f"{RESULTS}/logs/estimate_experiment/{{experiment}}.log",
    wildcard_constraints:
        experiment="|".join(EXPERIMENTS) or "study",
    priority: 100
    conda:
        ENVIRONMENT
    params:
        groups=lambda w: tried_by_strength(points_estimated(w.experiment)),
        scanned=lambda w: {
            rock: settings
            for rock, (_, settings) in scans_estimated(w.experiment).items()
        },
        code=code("estimate_experiment.py", titles=False),
    message:
        "Estimate the time of the joints of {wildcards.experiment} from a few of them"
    script:
        "../scripts/estimate_experiment.py"


# It has no output, so that it shows stored estimates again.
rule estimate:
    input:
        collect(
            f"{RESULTS}/tables/{{experiment}}_estimate.csv",
            experiment=EXPERIMENTS or ["study"],
        ),
    log:
        f"{RESULTS}/logs/estimate.log",
    conda:
        ENVIRONMENT
    params:
        notes=lambda w: notes_on_estimate(),
        assessed=(
            0.0 if PLAN is None or EXPERIMENTS else PLAN.seconds / PLAN.study_seconds
        ),
        code=code("show_estimates.py"),
    message:
        "Tables of the expected time are in {RESULTS}/tables"
    script:
        "../scripts/show_estimates.py"


# Targets, one for each experiment: `snakemake mismatch --configfile studies/mismatch/mismatch.yaml`


rule assessment:
    input:
        lambda w: files_of_experiment("assessment"),
    message:
        "The assessment is complete: {RESULTS}/tables/assessment.md"


rule global_sensitivity:
    input:
        lambda w: files_of_experiment("global_sensitivity"),
    message:
        "The experiment on global sensitivity is complete: {RESULTS}"


rule measured_joints:
    input:
        lambda w: files_of_experiment("measured_joints"),
    message:
        "The experiment on measured joints is complete: {RESULTS}"


rule misalignment:
    input:
        lambda w: files_of_experiment("misalignment"),
    message:
        "The experiment on tilted and rotated walls is complete: {RESULTS}"


rule mismatch:
    input:
        lambda w: files_of_experiment("mismatch"),
    message:
        "The experiment on mismatch and shift is complete: {RESULTS}"


rule size:
    input:
        lambda w: files_of_experiment("size"),
    message:
        "The experiment on patch length and grid spacing is complete: {RESULTS}"
