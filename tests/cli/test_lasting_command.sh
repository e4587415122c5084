#!/usr/bin/env bash
# Lasting credit from outside: lasting OUT, value --lasting, reproduce --lasting, and what uses the scores. Takes the program's path;
# test_lasting_run.c stops sweeps and forges steps.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

value() { "$program" value "$scene" --out "$folder/$1" "${small[@]}" --epochs 7 --quiet "${@:2}"; }
lasting() { "${by:-$program}" lasting "$folder/$1" --quiet "${@:2}"; }
select_photos() { rm -f "$folder/list.txt"; "$program" select "$folder/run" --to "$folder/list.txt" --method lasting_psnr --quiet "$@"; }

check "a run is valued" run value run
check "and swept afterwards" prints "^         Pearson's correlation (0\.[89]|1\.0)" "$program" lasting "$folder/run"
check "its price is told first" grep -qE \
    '^a backward pass and 6 short trainings that check it, about [0-9.]+ (s|min|h); Ctrl-C keeps what is done$' "$folder/stderr"
check "the gate names its photos" test "$(grep -cE '^ +[+-][0-9.]+ +[+-][0-9.]+  view_00' "$folder/stdout")" = 6
row=',lasting_(psnr|loss),-?[0-9.e-]+,(dB|mean absolute error),,7,[1-6],,,,$'
check "scores.csv has both scores, without stderr" test "$(grep -cE "$row" "$folder/run/scores.csv")" = 12
check "verify agrees" prints '^lasting credit +intact ' "$program" verify "$folder/run"
before=$(checksums run)
check "again: it is shown" prints '^highest lasting credit' lasting run
check "and nothing is written" test "$(checksums run)" = "$before"
check "JSON" run lasting run --json
check "has the gate" test "$(json '$.lasting.gate.trusted'),$(json '$.lasting.gate.photos[#-1].name')" = 1,view_005
check "the settings" test "$(json '$.lasting.steps'),$(json '$.lasting.rays'),$(json '$.lasting.has_zero')" = 42,0,0
check "and the same head" test "$(json '$.head')" = "$(query run 'SELECT final_hash FROM run')"

check "value --lasting does both" run value both --lasting --json --no-gate
check "in one" test "$(json '$.lasting.gate'),$(json '$.lasting.steps')" = ,42
check "with the same rows" test "$(query both 'SELECT * FROM lasting_step; SELECT * FROM score')" = \
    "$(query run 'SELECT * FROM lasting_step; SELECT * FROM score')"
check "by validation photo it is one more" run lasting both --lasting-matrix --no-gate
check "of all rays, with a row per step and photo" test \
    "$(query both 'SELECT rays, (SELECT count(*) FROM lasting_view) FROM lasting')" = '0|84'
check "matrix.csv has it" test "$(grep -c ',lasting_psnr,dB,' "$folder/both/matrix.csv")" = 6
check "whose means are the scores" test "$(awk -F, 'NR == FNR {if ($3 == "lasting_psnr") score[$1] = $4; next}
    $3 == "lasting_psnr" && ($5 - score[$1])^2 < 1e-6 && ($7 + $8 - 2 * $5)^2 < 1e-12 && ($7 - $8)^2 > 1e-6 {n++} END {print n}' \
    "$folder/both/scores.csv" "$folder/both/matrix.csv")" = 6
check "verify makes it again" prints '^matrix.csv +intact' "$program" verify "$folder/both"
sed -i 's/\(,lasting_psnr,dB,[^,]*,,\)/\13/' "$folder/both/matrix.csv"
check "and finds an edit" eval '! "$program" verify "$folder/both" 2>&1 | grep -q "^matrix.csv  *intact"'
check "--lasting-matrix belongs to --lasting" fails 2 '--lasting-matrix needs --lasting' value none --lasting-matrix

check "select ranks by it" prints '^kept     2 of 6 photos' select_photos --rule top:2
check "but knows no zero of it" fails 2 'zero that means nothing: only differences do' select_photos --rule positive

printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.3\n1,0,a,11,0.2\n2,0,b,12,0.1\n3,1,a,13,0.1\n4,1,b,14,0.1\n' >"$folder/log.csv"
check "an imported run" run "$program" import-steps "$folder/log.csv" --out "$folder/imported"
check "is refused" fails 2 'was imported, and its steps cannot be repeated' lasting imported
check "a folder without a run is named" fails 2 'no ledger here' lasting nothing

reproduce() { run "$lab" reproduce "$scene" --out "$folder/seeds" --seeds 2 "${small[@]}" --epochs 4 --quiet "$@"; }
check "two seeds" reproduce
check "are swept" reproduce --lasting --no-gate --json
check "their means" test "$(json '$.lasting.pairs'),$(json '$.lasting.methods[0].method'),$(json '$.lasting.gates[1]')" = 15,lasting_psnr,
seeds_table=$folder/seeds/lasting_seeds.csv
check "are in the table" test "$(head -n 1 "$seeds_table" | cut -d, -f1-8),$(wc -l <"$seeds_table")" = \
    name,method,unit,seeds,mean,stderr,ci_low,ci_high,13
check "a mean is that of the seeds" test "$(printf '%.9f' "$(json '$.lasting.methods[0].photos[3].mean')")" = "$(printf '%.9f' "$(
    sqlite3 "$folder/seeds/seed_0/ledger.db" "ATTACH '$folder/seeds/seed_1/ledger.db' AS b; SELECT (a.value + b.value) / 2
    FROM main.score AS a JOIN b.score AS b USING (image_id, method) JOIN main.image USING (image_id)
    WHERE method = 'lasting_psnr' AND name = 'view_003'")")"
check "text says what is told apart" eval 'reproduce --lasting --no-gate &&
    grep -qE "all intervals overlap|pairs of photos" "$folder/stdout"'

benchmark() { # benchmark [OPTION]...
    run "$lab" benchmark "$scene" --out "$folder/bench" --valued-seeds 1 --retraining-seeds 1 --subsets 8 --curves none \
        --worth-retrainings 8 "${small[@]}" --epochs 4 --quiet "$@"
}
worth_cost() { awk -F, '$2 == "cost/trainings" && $3 == "worth_8" {print $4}' "$folder/bench/benchmark.csv"; }
check "worth from 8 retrainings" benchmark
check "costs these and the run" test "$(worth_cost)" = 9
check "with a sweep for its prior" benchmark --lasting --no-gate
check "it costs that, too" test "$(worth_cost)" = 13
conclude "$@"
