#!/usr/bin/env bash
# `viewworth benchmark --methods` on a recipe of eight photos: a scorer per method and budget, its cost, what it agrees with, and that
# nothing is trained twice. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
tiny=(--epochs 3 --rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 6
    --width 16 --effects none --device llvmpipe --retraining-seeds 1 --valued-seeds 1 --curves none)

benchmark() { # benchmark OUT [OPTION]...
    run "$lab" benchmark "$root/scenes/eight.json" --out "$folder/$1" "${tiny[@]}" "${@:2}"
}
ask() { sqlite3 "$folder/all/retrainings.db" "$1"; }
retrainings() { ask 'SELECT count(*) FROM retraining'; }
value() { awk -F, -v metric="$1" -v method="$2" '$2 == metric && $3 == method {print $4}' "$folder/all/benchmark.csv"; }
at_least() { awk -v value="$2" -v least="$1" 'BEGIN {exit !(value != "" && value >= least)}' || ! echo "$2 is below $1"; }

# ---- All methods ----

check "a benchmark of all methods and all subsets" benchmark all --subsets all --methods all --run-equivalents 2,N,9
for method in tmc_shapley_N tmc_shapley_9 data_banzhaf_2 data_banzhaf_N leave_one_out_9 data_oob_2 data_oob_9 dvrl_N g_shapley_2 \
    g_shapley_9; do
    check "a table row of $method" grep -qE "^$method +" "$folder/stdout"
    for metric in exact_shapley/val_psnr exact_banzhaf/val_psnr exact_leave_one_out/test_psnr lds/val_psnr cost/trainings; do
        check "  and $metric" test -n "$(value "$metric" "$method")"
    done
    check "  within its budget" at_least "$(value cost/trainings "$method")" "$(budget=${method##*_} && echo "${budget/N/8}")"
done
check "the untrained field is one of 256 subsets" test "$(ask 'SELECT count(*) FROM retraining WHERE view_count = 0 AND seed = 1')" = 1
check "exact values of all photos" test "$(wc -l <"$folder/all/exact.csv")" = 9
check "with their header" grep -q '^name,shapley_db,banzhaf_db,leave_one_out_db,test_shapley_db,' "$folder/all/exact.csv"
# What all photos gain over the untrained field is divided among them.
check "Shapley values add up" test "$(ask "SELECT round(
    (SELECT val_psnr FROM retraining WHERE view_count = 8 AND seed = 1) -
    (SELECT val_psnr FROM retraining WHERE view_count = 0 AND seed = 1) -
    $(awk -F, 'NR > 1 {sum += $2} END {printf "%.12f", sum}' "$folder/all/exact.csv"), 6) = 0")" = 1
check "an order of all photos takes one training for each" test "$(value cost/trainings tmc_shapley_N)" = 8
check "an epoch takes a third of three" test "$(ask 'SELECT count(*) FROM retraining WHERE epochs = 1')" -ge 27
check "a budget that is too small is left out" test -z "$(value cost/trainings tmc_shapley_2)$(value cost/trainings leave_one_out_N)"
check "which the log says" grep -q 'leave_one_out_N is left out: it takes 9 to' "$folder/stderr"
check "photos are measured that were left out" test "$(ask 'SELECT count(*) FROM view WHERE image_id < 8')" -gt 0
check "signs are evaluated where there are any" test -n "$(value sign_accuracy/val_psnr tmc_shapley_N)"
check "and nowhere else" test -z "$(value sign_accuracy/val_psnr dvrl_N)$(value sign_accuracy/val_psnr data_oob_9)"
check "no retraining that judges has a seed of theirs" test \
    "$(ask 'SELECT count(*) FROM retraining WHERE seed BETWEEN 1 AND 1000000')" = 256

# ---- Resuming and larger budgets ----

cp "$folder/all/benchmark.csv" "$folder/first.csv"
before=$(retrainings)
check "it is repeated" benchmark all --subsets all --methods all --run-equivalents 2,N,9 --json
check "with the same bytes" cmp "$folder/first.csv" "$folder/all/benchmark.csv"
check "and without a training" test "$(retrainings)" = "$before"
check "its JSON has seconds" grep -q '"seconds"' "$folder/stdout"
check "a larger budget" benchmark all --subsets all --methods tmc_shapley --run-equivalents 8,5N
check "keeps the retrainings of a smaller one" test "$(($(retrainings) - before))" -le 40
check "and the scores" test "$(value exact_shapley/val_psnr tmc_shapley_8)" = \
    "$(awk -F, '$2 == "exact_shapley/val_psnr" && $3 == "tmc_shapley_N" {print $4}' "$folder/first.csv")"
check "and agrees with the exact Shapley values" at_least 0.8 "$(value exact_shapley/val_psnr tmc_shapley_5N)"

# ---- Valued seeds ----

check "two valued seeds" benchmark two --subsets 8 --valued-seeds 2 --methods data_banzhaf --run-equivalents 4
check "draw and train each for itself" test "$(sqlite3 "$folder/two/retrainings.db" 'SELECT count(*) FROM retraining a
    JOIN retraining b ON b.seed = a.seed + 1048576 WHERE a.views <> b.views AND a.seed >= 1073741824')" -gt 1

# ---- Refusals ----

refused() { "$lab" benchmark "$root/scenes/eight.json" --out "$folder/refused" "${tiny[@]}" --quiet "$@"; }
check "a method that is none" fails 2 '--methods: "shapley" is none' refused --methods tmc_shapley,shapley
check "budgets without methods" fails 2 'run-equivalents needs --methods' refused --run-equivalents 4
for list in 0 N/0 N2 4n 1.5 '' 1,, 1,2,3,4,5,6,7,8,9,10,11,12,13; do
    check "budgets of \"$list\"" fails 2 'run-equivalents takes up to 12 numbers' refused --methods all --run-equivalents "$list"
done
check "a curve of a budget is known, of a method alone not" fails 2 '"dvrl" is not a method' refused --curves dvrl_N,dvrl
check "nothing is left of refusals" test ! -e "$folder/refused"
conclude
