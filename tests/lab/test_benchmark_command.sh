#!/usr/bin/env bash
# `viewworth benchmark` on a tiny recipe: what it writes, and that it trains nothing twice. Takes the
# program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
cp "$root/tests/support/tiny.json" "$folder"
sed '/"defects"/d; s/"split": "test"}],/"split": "test"}]/' "$folder/tiny.json" >"$folder/sound.json"
tiny=(--epochs 3 --rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 6
    --width 16 --effects none --device llvmpipe)

benchmark_it() { "$lab" benchmark "$folder/tiny.json" --out "$folder/$1" "${tiny[@]}" "${@:2}"; } # benchmark_it OUT [OPTION]...
benchmark() { run benchmark_it "$@"; }
ask() { sqlite3 "$folder/$1/retrainings.db" "$2"; }
retrainings() { ask "$1" 'SELECT count(*) FROM retraining'; }
row() { grep -c "^$folder/tiny.json,$1," "$folder/whole/benchmark.csv"; } # row METRIC,METHOD: how many there are

# ---- What it leaves ----

check "a benchmark without interruption" benchmark whole --subsets 8 --leave-one-out
check "the table names methods and baselines" grep -qE '^dv_psnr +-?[01]\.' "$folder/stdout"
check "it says what the truth is" grep -q '4 random halves and 4 subsets of 40 to 100 %, 2 trainings of each' "$folder/stdout"
check "and what trainings have in common" grep -q 'at equal steps, by test PSNR' "$folder/stdout"
check "and that it is a mean over epochs" grep -q 'the ends of the last 3 epochs' "$folder/stdout"
check "and the noise ceiling" grep -q '^noise ceiling' "$folder/stdout"
check "two valued runs" test -f "$folder/whole/seed_0/scores.csv" -a -f "$folder/whole/seed_1/scores.csv"
check "the CSV has its header" test "$(head -n 1 "$folder/whole/benchmark.csv")" = scene,metric,method,value,ci_low,ci_high,count
for wanted in auc/noise,dv_psnr auc/wrong_pose,dv_loss auc/corrupted,sharpness auc/harmful,random seed_pearson/all,dv_psnr \
    seed_spearman/clean,dv_psnr lds/val_psnr,dv_psnr lds/test_psnr,ground_truth lds_gain/val_psnr,train_loss "lds/val_psnr,noise ceiling" \
    lds_sizes/test_psnr,dv_psnr lds/val_psnr,consistent_residual lds/val_psnr,lava auc/corrupted,sfm_coverage \
    lds_mean/val_psnr,dv_psnr lds_sizes/val_psnr,subset_worth "lds_sizes/val_psnr,chance" \
    left_out_r2/test_psnr,subset_worth sign_accuracy/test_psnr,dv_psnr harmful_recall/val_psnr,dv_loss \
    harm/wrong_pose,retrainings removal_low/20,dv_psnr removal_low/50,random addition_high/30,ground_truth \
    leave_one_out/test_psnr,sfm_points leave_one_out_mean/val_psnr,dv_psnr "leave_one_out/val_psnr,noise ceiling" \
    cost/trainings,leave_one_out agreement_lds/test_psnr,outcomes; do
    check "a row $wanted" test "$(row "$wanted")" = 1
done
check "ground truth finds all corrupted photos" \
    grep -q "^$folder/tiny.json,auc/corrupted,ground_truth,1,1,1,8$" "$folder/whole/benchmark.csv"
check "a baseline has no sign" test "$(row sign_accuracy/val_psnr,random)" = 0
check "worths of all photos" test "$(wc -l <"$folder/whole/worths.csv")" = 7
check "with their header" test "$(head -n 1 "$folder/whole/worths.csv")" = \
    name,worth_db,ci_low,ci_high,test_worth_db,test_ci_low,test_ci_high
check "features of all photos, of both valued seeds" test "$(wc -l <"$folder/whole/photo_features.csv")" = 13
check "with their header" \
    grep -q "^name,seed,brightness,.*,sfm_coverage,.*,transport,loss_first,.*,credit_l1$" "$folder/whole/photo_features.csv"
check "and what the run tells" test "$(cut -d, -f 17- "$folder/whole/photo_features.csv" | grep -c ',,\|^,\|,$')" = 0
check "halves come in pairs of seeds" test "$(ask whole 'SELECT count(*) FROM (
    SELECT views FROM retraining WHERE view_count = 3 GROUP BY views HAVING count(*) <> 2 OR min(seed) <> 2 OR max(seed) <> 3)')" = 0
check "no retraining has a seed whose scores are evaluated" test "$(ask whole 'SELECT count(*) FROM retraining WHERE seed < 2')" = 0
check "leaving one out has seeds of its own" test "$(ask whole 'SELECT min(seed) || max(seed) FROM retraining WHERE view_count = 5
    AND seed > 3')" = 45

check "a benchmark of five trainings at a time" benchmark together --subsets 8 --leave-one-out --together 5
check "has the same bytes" cmp "$folder/whole/benchmark.csv" "$folder/together/benchmark.csv"
check "of features, too" cmp "$folder/whole/photo_features.csv" "$folder/together/photo_features.csv"
lengthen() {
    local seed
    for seed in 0 1; do run "$lab" probe "$folder/together/seed_$seed" --lengthen 30 --quiet || return 1; done
}
check "its valued runs are taken again with longer steps" lengthen
check "which are compared with leaving photos out" \
    grep -qE '^\| lengthened steps \| -?[01]\.' <("$root/scripts/lab/compare_scores" "$folder/together")

# ---- Resuming and reusing ----

cp "$folder/whole/benchmark.csv" "$folder/first.csv"
before=$(retrainings whole)
check "a finished benchmark is repeated" benchmark whole --subsets 8 --leave-one-out
check "with the same bytes" cmp "$folder/first.csv" "$folder/whole/benchmark.csv"
check "and without a training" test "$(retrainings whole)" = "$before"
extend_seeds() {
    local seed
    for seed in 0 1; do
        run "$lab" value "$folder/tiny.json" --out "$folder/whole/seed_$seed" --seed "$seed" "${tiny[@]}" --epochs 5 --resume ||
            return 1
    done
}
check "its valued runs are extended" extend_seeds
check "and it is repeated with the epochs that it had" benchmark whole --subsets 8 --leave-one-out
check "with the same bytes once more" cmp "$folder/first.csv" "$folder/whole/benchmark.csv"
check "and again without a training" test "$(retrainings whole)" = "$before"
check "more subsets add trainings" benchmark whole --subsets 10 --curves none --json
check "of the new subsets alone" test "$(($(retrainings whole) - before))" -le 4
check "its JSON is whole" grep -q '"metrics"' "$folder/stdout"
check "without curves none are evaluated" test "$(row removal_low/20,random)" = 0

# ---- Nothing to tell ----

evaluate_sound() {
    run "$lab" benchmark "$folder/sound.json" --out "$folder/sound" "${tiny[@]}" --epochs 2 --subsets 8 --curves ground_truth
}
curve() { grep -c "^$folder/sound.json,removal_low/20,$1," "$folder/sound/benchmark.csv"; }
check "a benchmark of photos that are all sound" evaluate_sound
check "has the curve of random orders" test "$(curve random)" = 1
check "and none of a ground truth that is the same for all" test "$(curve ground_truth)" = 0

# ---- Refusals ----

refused() { benchmark_it refused "$@" --quiet; }
check "too few subsets" fails 2 'subsets' refused --subsets 3
check "subsets of a word" fails 2 'subsets takes all or' refused --subsets every
sed 's/"count": 6/"count": 11/' "$folder/tiny.json" >"$folder/eleven.json"
check "all subsets of eleven photos" fails 2 'at most 10 photos' "$lab" benchmark "$folder/eleven.json" --out "$folder/eleven" \
    "${tiny[@]}" --subsets all --quiet
check "which trains nothing" test ! -e "$folder/eleven/seed_0"
check "no seeds left to evaluate with" fails 2 'seed.*lower' refused --seed 9223372036854775804
check "no epoch to score" fails 2 'burn-in' refused --epochs 1
check "a recipe has defects of its own" fails 2 'corrupt.*recipe' refused --corrupt 2
check "a curve of no method" fails 2 '--curves: "dv_pnsr" is not a method' refused --curves ground_truth,dv_pnsr
check "nothing is left of refusals" test ! -e "$folder/refused"
check "a folder that holds a run of value" fails 2 'holds a single run' benchmark_it whole/seed_0 --quiet
check "no such scene" fails 2 'nowhere' "$lab" benchmark "$folder/nowhere" --out "$folder/refused" --quiet
mkdir -p "$folder/other" && echo "no retrainings" >"$folder/other/retrainings.db"
check "a file that holds no retrainings" fails 2 'retrainings.db.*not' benchmark_it other --quiet
check "which stays as it was" test "$(cat "$folder/other/retrainings.db")" = "no retrainings"
conclude
