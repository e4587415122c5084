#!/usr/bin/env bash
# `viewworth tradeoff` on a tiny recipe: what it leaves, that its metrics are what the runs say, and that it trains nothing
# twice. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
cp "$root/tests/support/tiny.json" "$folder"
tiny=(--epochs 8 --rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 6
    --width 16 --effects none --device llvmpipe)

sweep_it() { "$lab" tradeoff "$folder/tiny.json" --out "$folder/$1" --seeds 2 "${tiny[@]}" "${@:2}"; } # sweep_it OUT [OPTION]...
sweep() { run sweep_it "$@"; }
ask() { # ask OUT SQL: of tradeoff.csv as the table `metric`, and evaluation.csv as `evaluation`
    local name table column commands=()
    for name in metric:tradeoff evaluation:evaluation; do
        table=${name%:*} name=$folder/$1/${name#*:}.csv
        commands+=(-cmd "CREATE TABLE $table ($(head -n 1 "$name" | sed -E 's/,/ NUMERIC, /g; s/$/ NUMERIC/
            s/\b(configuration|parameter|value|method) NUMERIC/\1 TEXT/g'))" -cmd ".import --csv --skip 1 $name $table")
        for column in $(head -n 1 "$name" | tr , ' '); do
            commands+=(-cmd "UPDATE $table SET $column = NULL WHERE $column = ''")
        done
    done
    sqlite3 :memory: "${commands[@]}" "$2"
}
metric() { ask whole "SELECT $2 FROM metric WHERE method = 'dv_psnr' AND configuration = '$1'"; }

# ---- What it leaves ----

parameters=(--parameters rays,val-rays,epochs --halves 8)
check "a sweep" sweep whole "${parameters[@]}"
check "it says beforehand how long it takes" grep -qE \
    '^tradeoff [0-9]+ configurations with 2 seeds each.*about [0-9.]+ (s|min|h) .*; Ctrl-C keeps what is done$' "$folder/stderr"
rows=$(grep -cE '^(base|full_resolution|rays-|val-rays-|epochs-)' "$folder/stdout")
check "the table has a row per configuration" test "$rows" = "$(ask whole 'SELECT count(DISTINCT configuration) FROM metric')"
check "so has the evaluation" test "$(wc -l <"$folder/whole/evaluation.csv")" = "$(wc -l <"$folder/whole/tradeoff.csv")"
check "the CSV has its header" test "$(head -n 1 "$folder/whole/tradeoff.csv")" = "configuration,parameter,value,base,epochs,steps,\
train_ms,value_ms,\
scoring_ratio,run_seconds,device_mib,val_psnr,psnr_pareto_front,method,seed_pearson,agreement_pearson"
knees=$(grep -cE "^knee .*: (base|rays-|val-rays-|epochs-).* reaches [0-9.]+ in " "$folder/stdout")
check "it says where the knees are" test "$knees" = 3
for configuration in base full_resolution rays-2 rays-32 val-rays-128 epochs-2 epochs-16; do
    check "a configuration $configuration with its runs" test -f "$folder/whole/configurations/$configuration/seed_1/scores.csv" \
        -a -n "$(metric $configuration val_psnr)"
done
check "no parameter that was not named" test ! -e "$folder/whole/configurations/width-32"
check "a value like the base's is not tried twice" test ! -e "$folder/whole/configurations/val-rays-64" \
    -a ! -e "$folder/whole/configurations/rays-16"
check "the base is one" test "$(ask whole "SELECT group_concat(DISTINCT configuration) FROM metric WHERE base")" = base
check "it lists all parameters" grep -q '^base,base,"rays 16, samples 8, importance-samples 0, val-rays 64, .*, downscale 1",1,8,48,' \
    "$folder/whole/tradeoff.csv"
check "steps are photos times epochs" test "$(metric epochs-2 steps)" = 12

# ---- That metrics are what the runs say ----

check "the full_resolution configuration agrees with itself" near 1 "$(metric full_resolution agreement_pearson)"
check "validation does not change the training" test "$(metric base val_psnr)" = "$(metric val-rays-128 val_psnr)"
rendered_psnr() { # rendered_psnr CONFIGURATION: mean over both seeds and both validation photos, by another command
    local seed view
    for seed in 0 1; do
        for view in 0 1; do
            "$program" render "$folder/whole/configurations/$1/seed_$seed" --view $view --to "$folder/view.png" --device llvmpipe --quiet
        done
    done | awk '/PSNR/ {sum += $3} END {print sum / 4}'
}
check "PSNR is what rendering the fields gives" near "$(metric base val_psnr)" "$(rendered_psnr base)" 0.01 # it prints two digits
run "$lab" reproduce "$folder/tiny.json" --out "$folder/whole/configurations/base" --seeds 2 "${tiny[@]}" --effects none
check "seeds agree as reproduce has it" near "$(metric base seed_pearson)" \
    "$(awk -F, '$1 == "dv_psnr" && $2 == 8 && $7 == "pearson" {print $8}' "$folder/whole/configurations/base/reproduce.csv")"
auc_of_seed() { # the share of pairs of a clean photo and a corrupted one that the scores order
    sqlite3 "$folder/whole/configurations/base/seed_$1/ledger.db" "SELECT avg((c.value > s.value) + (c.value = s.value) / 2.0)
        FROM score c JOIN image i USING (image_id) JOIN score s JOIN image j ON j.image_id = s.image_id
        WHERE c.method = 'dv_psnr' AND s.method = 'dv_psnr' AND i.ground_truth = 'clean' AND j.ground_truth <> 'clean'"
}
check "AUC is the mean over the seeds" near \
    "$(ask whole "SELECT auc FROM evaluation WHERE method = 'dv_psnr' AND configuration = 'base'")" \
    "$(awk -v a="$(auc_of_seed 0)" -v b="$(auc_of_seed 1)" 'BEGIN {printf "%.17g", (a + b) / 2}')"
check "the Pareto front is what nothing beats" test "$(ask whole "SELECT count(*) FROM metric a WHERE psnr_pareto_front <>
    (NOT EXISTS (SELECT 1 FROM metric b WHERE b.run_seconds <= a.run_seconds AND b.val_psnr >= a.val_psnr
        AND (b.run_seconds < a.run_seconds OR b.val_psnr > a.val_psnr)))")" = 0
check "8 halves, each twice, with seeds of their own" test "$(sqlite3 "$folder/whole/retrainings.db" \
    'SELECT count(*) || min(seed) || max(seed) FROM retraining')" = 1623
check "LDS lies in its interval" test "$(ask whole 'SELECT count(*) FROM evaluation WHERE lds < lds_ci_low OR lds > lds_ci_high')" = 0
check "LDS is there" test "$(ask whole 'SELECT count(DISTINCT configuration) FROM evaluation WHERE lds IS NOT NULL')" = "$rows"

placed=(--parameters importance-samples,learning-rate-decay --halves 0 --epochs 2)
check "placed samples are tried" sweep placed "${placed[@]}"
check "all of them" test -d "$folder/placed/configurations/importance-samples-8" -a -d "$folder/placed/configurations/importance-samples-32"
check "and rates that fall" test "$(sqlite3 "$folder/placed/configurations/learning-rate-decay-0.3/seed_0/ledger.db" \
    "SELECT json_extract(config_json, '\$.learning_rate_decay') FROM run")" = 0.3
check "values that end within burn-in are left out" sweep late --parameters epochs,accuracy --halves 0 --burn-in 80 --epochs 81
check "and those beside them are not" test "$(ask late "SELECT group_concat(configuration, ' ') FROM metric WHERE method = 'dv_psnr'")" = \
    "base full_resolution epochs-162"

# ---- Resuming ----

untimed() { ask whole "SELECT configuration, steps, device_mib, val_psnr, method, seed_pearson, agreement_pearson FROM metric"; }
untimed >"$folder/first.txt"
touch "$folder/after"
check "a finished sweep is repeated" sweep whole "${parameters[@]}" --json
check "with the same metrics" eval 'untimed | cmp "$folder/first.txt" -'
check "JSON has every row" test "$(sqlite3 :memory: "SELECT json_array_length(CAST(readfile('$folder/stdout') AS TEXT), '\$.metrics')")" = \
    "$(ask whole 'SELECT count(*) FROM metric')"
check "without a step" test -z \
    "$(find "$folder/whole/configurations" "$folder/whole/retrainings.db" -name '*.db' -newer "$folder/after")"
check "without halves there is no LDS" test -z "$(ask late 'SELECT max(lds) FROM evaluation')"

# ---- What is refused, before anything is written ----

for wrong in "--parameters: \"ray\" is none of rays|--parameters rays,ray" "agreement between seeds needs two --seeds or more|--seeds 1" \
    "leaves no epoch after --burn-in|--epochs 1" "the 2 seeds from it on pass|--seed 9223372036854775807"; do
    # shellcheck disable=SC2086
    check "refused: ${wrong#*|}" fails 2 "${wrong%%|*}" sweep_it none --quiet ${wrong#*|}
done
all=$("$lab" tradeoff --help | tr -s '[:space:]' ' ' | sed -n 's/.*with commas between: \([^(]*\) (default all).*/\1/p' | tr -d ' ')
check "every parameter of the help is one" fails 2 '"none-such" is none of' sweep_it none --quiet --parameters "$all,none-such"
check "an --out that is a file" fails 2 'is a file; name a folder' sweep_it first.txt --quiet
check "nothing is written" test ! -e "$folder/none"
conclude
