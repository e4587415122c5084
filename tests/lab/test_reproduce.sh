#!/usr/bin/env bash
# The same scene valued with several seeds: what agrees, what a seed varies, and resume. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
scene=$folder/corrupted.json
sed '0,/^{/s//{ "defects": [{"kind": "noise", "views": [1, 2], "strength": 0.4}],/' "$root/scenes/clean.json" >"$scene"

reproduce() { run reproduce_it "$@"; } # reproduce OUT [OPTION]...
reproduce_it() { "$lab" reproduce "$scene" --out "$folder/$1" --epochs 6 "${small[@]}" --quiet "${@:2}"; }

refused() { fails 2 "$2" reproduce_it "$1" "${@:3}"; } # refused OUT PATTERN [OPTION]...

table() { # table OUT FILE SQL: of a CSV file, as the table t
    sqlite3 -cmd '.mode csv' -cmd ".import $folder/$1/$2 t" -cmd '.mode list' :memory: "$3"
}
same_tables() { cmp "$folder/$1/reproduce.csv" "$folder/$2/reproduce.csv" && cmp "$folder/$1/scatter.csv" "$folder/$2/scatter.csv"; }
same_reproduction() { # same_reproduction OUT OUT: whole, of three seeds
    local k
    same_tables "$1" "$2" || return 1
    for k in 0 1 2; do same_run "$1/seed_$k" "$2/seed_$k" || return 1; done
}

check "three seeds" reproduce whole --seeds 3
r='-?[01]\.[0-9]{3}'
check "the table has a row per method, r and rho first" grep -qE "^dv_psnr +$r \[$r $r\] +$r \[$r $r\] " "$folder/stdout"
check "and one per number of epochs" test "$(grep -cE '^ +[56] +(3840|4608) ' "$folder/stdout")" = 2
value() { run "$lab" value "$scene" --out "$folder/$1" --epochs 6 "${small[@]}" --quiet "${@:2}"; }
check "a seed's run is the one of value" eval 'value alone --seed 1 && same_run alone whole/seed_1'
check "also where effects are decided, once for all seeds" eval 'reproduce decided --seeds 2 --effects auto --pilot-steps 8 &&
    value decided_alone --seed 1 --effects auto --pilot-steps 8 && same_run decided_alone decided/seed_1'
check "the header of reproduce.csv" grep -qx 'method,epochs,training_rays,seed_a,seed_b,photos,measure,value' \
    <(head -n 1 "$folder/whole/reproduce.csv")
check "the header of scatter.csv" grep -qx 'name,method,seed_a,seed_b,value_a,value_b,corrupted' <(head -n 1 "$folder/whole/scatter.csv")
methods=$(table whole scatter.csv "SELECT count(DISTINCT method) FROM t")
check "a row per method, stop, pair and measure" test "$methods" -ge 2 -a \
    "$(table whole reproduce.csv 'SELECT count(*) FROM t')" = $((methods * 2 * 3 * 8))
check "a point per method, pair and photo" test "$(table whole scatter.csv 'SELECT count(*) FROM t')" = $((methods * 3 * 12))
check "the corrupted are known" test "$(table whole scatter.csv "SELECT group_concat(DISTINCT name) FROM t WHERE corrupted = '1'")" = \
    view_001,view_002
check "and not among the clean" test "$(table whole reproduce.csv "SELECT DISTINCT photos FROM t
    WHERE measure = 'clean_pearson'")" = 10
check "a rank has no signs to agree on" test "$(table whole reproduce.csv "SELECT group_concat(DISTINCT measure) FROM t
    WHERE method = 'quality' AND value = '' AND photos = '12' AND epochs = '6'")" = positive_jaccard,same_sign,sign_kappa
check "points are the ledgers' scores" test "$(table whole scatter.csv "ATTACH '$folder/whole/seed_2/ledger.db' AS ledger;
    SELECT count(*), max(abs(value_b - value)) FROM t JOIN ledger.image USING (name) JOIN ledger.score USING (image_id, method)
    WHERE seed_b = 2 AND seed_a = 0")" = "$((methods * 12))|0.0"

# Pearson's r again, by another program, from the points.
recompute_pearson() {
    sqlite3 :memory: <<SQL
.mode csv
.import $folder/$1/scatter.csv point
.import $folder/$1/reproduce.csv agreement
.mode list
WITH mean AS (SELECT method, seed_a, seed_b, avg(value_a) AS a, avg(value_b) AS b FROM point GROUP BY 1, 2, 3),
     again AS (SELECT method, seed_a, seed_b, sum((value_a - a) * (value_b - b)) /
                      sqrt(sum((value_a - a) * (value_a - a)) * sum((value_b - b) * (value_b - b))) AS r
               FROM point JOIN mean USING (method, seed_a, seed_b) GROUP BY 1, 2, 3)
SELECT count(*), max(abs(r - value)) < 1e-12 FROM again JOIN agreement USING (method, seed_a, seed_b)
WHERE measure = 'pearson' AND epochs = '6' AND value <> '';
SQL
}
check "r is that of the points" test "$(recompute_pearson whole)" = "$((methods * 3))|1"

before=$(checksums whole)
check "again: nothing is left to do" reproduce whole --seeds 3 --json
check "and nothing changes" test -n "$before" -a "$(checksums whole)" = "$before"
cp -r "$folder/whole" "$folder/paper"
check "--paper compares the paper's other scores, too" reproduce paper --seeds 3 --paper
check "which are in the tables" test "$(table paper scatter.csv "
    SELECT count(DISTINCT method) - $methods, sum(method = 'revisit_loss') FROM t")" = '5|36'
check "but in no ledger" test "$(query paper/seed_1 'SELECT count(DISTINCT method) FROM score')" = "$methods"
run reproduce_it whole --seeds 3 --json
check "the JSON says the same" test "$(printf '%.9f' "$(json '$.by_epochs[#-1].methods[0].pearson.lowest')")" = \
    "$(printf '%.9f' "$(table whole reproduce.csv "SELECT min(CAST(value AS REAL)) FROM t
        WHERE method = 'dv_psnr' AND measure = 'pearson' AND epochs = '6'")")"
check "and the intervals that hold the mean" test "$(json '$.by_epochs[#-1].methods[0].interval_coverage.intervals')" = 36
check "and what varied" test "$(json '$.vary'),$(json '$.seeds[2]'),$(json '$.photos')" = all,2,12

check "two of the seeds, taken together" reproduce pair --seeds 2 --together 2
check "and one more" reproduce pair --seeds 3 --together 3
check "are the three" same_reproduction whole pair
check "fewer epochs" reproduce short --seeds 3 --epochs 5 --together 3
check "that are taken further, two together" reproduce short --seeds 3 --together 2
check "are those" same_reproduction whole short
check "--device is one, --devices are several" refused one 'give either --device or --devices' --seeds 2 --devices 0
check "a list of devices has no gaps" on_two_devices small refused one '--devices takes all, or 1 to 16 indices' --seeds 2 --devices 0,,1
same_of_seeds() { # same_of_seeds OUT SQL: "same" or "other"
    local answers=("$(query "$1/seed_0" "$2")" "$(query "$1/seed_1" "$2")")
    [[ -n ${answers[0]} && ${answers[0]} == "${answers[1]}" ]] && echo same || echo other
}
# varies OUT ORDER START: whether two seeds have the same order, and the same untrained field; in the end they differ
varies() {
    local order start
    reproduce "$1" --seeds 2 --vary "$1" || return 1
    order=$(same_of_seeds "$1" 'SELECT group_concat(image_id) FROM step')
    start=$(same_of_seeds "$1" 'SELECT val_psnr FROM step WHERE step = 0')
    [[ $order,$start,$(same_of_seeds "$1" 'SELECT val_psnr FROM step WHERE step = 60') == "$2,$3,other" ]]
}
check "--vary order" varies order other same
check "--vary all" varies all other other
steps() { query "$1" 'SELECT val_psnr, image_id FROM step WHERE step > 0'; }
losses='SELECT group_concat(train_loss) FROM step WHERE step > 0' # of the training alone
check "--vary validation: the same training, seen on other pixels" eval 'reproduce validation --seeds 2 --vary validation &&
    [[ $(same_of_seeds validation "$losses"),$(same_of_seeds validation "SELECT val_psnr FROM step WHERE step = 0") == same,other ]]'
check "validation pixels are those of a replay" "$program" verify "$folder/validation/seed_1" --replay 5 --device llvmpipe --quiet
check "the base seed's run has the same steps, whatever varies" eval '[[ -n $(steps all/seed_0) &&
    $(steps order/seed_0) == "$(steps all/seed_0)" ]]'
check "what varies is taken again by a replay" "$program" verify "$folder/order/seed_1" --replay 5 --device llvmpipe --quiet
check "what varies is part of what a run is" refused order 'seed_0 has vary = "order", not "all"' --seeds 2 --vary all
check "and named when it is another" refused order 'seed_0 has vary = "order", not "pixels"' --seeds 2 --vary pixels
check "and the base seed, too" refused order 'seed_1 has base_seed = 0, not 1' --seeds 2 --seed 1 --vary order
check "seeds are counted from --seed" eval 'reproduce far --seeds 2 --seed 9223372036854775806 &&
    test -s "$folder/far/seed_9223372036854775807/ledger.db"'

# ---- Methods of the literature ----

of_methods() { # of_methods COMMAND [OPTION]...
    run "$lab" "$1" "$root/scenes/eight.json" --out "$folder/methods" --epochs 3 --rays 16 --samples 8 --val-rays 64 --levels 2 \
        --log2-table 6 --width 16 --effects none --device llvmpipe --run-equivalents 4 "${@:2}"
}
retrainings() { sqlite3 "$folder/methods/retrainings.db" 'SELECT count(*) FROM retraining WHERE seed >= 1 << 30'; }
agreements() { table methods reproduce.csv "SELECT count(*) FROM t WHERE method = '$1' AND measure = '$2' AND value <> ''"; }
check "two seeds by methods of the literature" of_methods reproduce --seeds 2 --methods data_banzhaf,data_oob,in_run_shapley --json
banzhaf='$.by_epochs[#-1].methods[#-3]'
check "their cost is told" test "$(json "$banzhaf.method"),$(json "$banzhaf.cost.run_equivalents")" = data_banzhaf_4,4.0
check "the CPU time of their retrainings, too" eval '[[ $(json "$banzhaf.cost.seconds") =~ [1-9] ]]'
for method in data_banzhaf_4 data_oob_4 in_run_shapley dv_psnr consistent_residual; do
    check "$method has an agreement" test "$(agreements "$method" pearson)" = 1
done
check "the sign of what is no worth says nothing" test "$(agreements data_oob_4 same_sign),$(agreements data_banzhaf_4 same_sign)" = 0,1
check "what depends on no run is left out" test "$(agreements sharpness pearson)" = 0
check "each photo has a point" test "$(table methods scatter.csv "SELECT count(DISTINCT name), count(*) FROM t
    WHERE method = 'data_banzhaf_4' AND value_a <> value_b")" = '8|8'
made=$(retrainings)
before=$(checksums methods)
check "again: nothing is left to do" of_methods reproduce --seeds 2 --methods data_banzhaf,data_oob,in_run_shapley
check "and no file changes" test "$made" -ge 16 -a "$(checksums methods)" = "$before"
check "a benchmark of the same runs" of_methods benchmark --valued-seeds 2 --methods data_banzhaf,data_oob --subsets 8 \
    --retraining-seeds 1 --curves none
check "takes the retrainings that are there" test "$(retrainings)" = "$made"

# ---- What is refused ----

check "one seed agrees with none" refused one '--seeds takes a whole number, 2 to 50' --seeds 1
check "a seed beyond the largest is refused" refused one 'pass 9223372036854775807' --seeds 3 --seed 9223372036854775806
check "an unknown form is refused" refused one '"colour" is not one of all\|order\|pixels\|init\|validation\|all,validation' --vary colour
check "epochs that all burn in are refused" refused one 'leaves no epoch after --burn-in 6' --burn-in 6
check "nothing is left of refusals" test ! -e "$folder/one"
check "a folder that holds a run of value is refused" refused alone 'holds a single run; name another folder' --seeds 2
check "another config is refused by name" refused whole 'seed_0 has rays = 64, not 65' --seeds 3 --rays 65
mkdir -p "$folder/other" && echo x >"$folder/other/seed_1" && echo x >"$folder/file"
check "a file in a run's place is refused" refused other 'seed_1: is another kind of file' --seeds 2
check "and one in the folder's" refused file 'is a file; name a folder' --seeds 2
mkdir -p "$folder/beside/seed_1/ledger.db"
check "one of three together that cannot be opened is refused" refused beside 'seed_1/ledger.db' --seeds 3 --together 3
check "and what had begun is made" same_run whole/seed_0 beside/seed_0
conclude "$@"
