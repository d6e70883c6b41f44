# Constants of the bearing-area law of `jointclosure.estimate`: `snakemake surrogate`, from the joints
# of a finished study. The package ships those of the default study's walls and those of walls with
# waves of all lengths (config/no_roll_off.yaml): `python docs/site/publish.py results/paper
# surrogate_roll_off` and `results/no_roll_off surrogate_no_roll_off` renew them.


rule surrogate:
    input:
        f"{RESULTS}/tables/surrogate.csv",
    message:
        "The constants of the bearing-area law are in {input[0]}"


rule calibrate_surrogate:
    input:
        pool=POOL,
    output:
        f"{RESULTS}/tables/surrogate.csv",
    params:
        grid=to_plain(CONFIGURATION.grid),
        surface=to_plain(CONFIGURATION.surface),
    script:
        "../scripts/calibrate_surrogate.py"
