#!/usr/bin/env bash
# value --kfold: train and validation photos validate in turn, and scores are means over the trainings. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
tiny=(--rays 32 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 8 --width 16
   --effects none --device llvmpipe --epochs 4)

kfold() { run "$program" value "$scene" --out "$folder/$1" "${tiny[@]}" --quiet --no-thumbnails "${@:2}"; } # kfold OUT [OPTION]...
refused() { fails 2 "$2" "$program" value "$scene" --out "$folder/$1" "${tiny[@]}" --quiet "${@:3}"; } # refused OUT PATTERN ...
table() { # table FILE SQL: of a CSV file in whole, as the table t; its ledgers are f1, f2, f3
    sqlite3 -cmd '.mode csv' -cmd ".import $folder/whole/$1 t" -cmd '.mode list' -cmd "ATTACH '$folder/whole/fold-1/ledger.db' AS f1" \
        -cmd "ATTACH '$folder/whole/fold-2/ledger.db' AS f2" -cmd "ATTACH '$folder/whole/fold-3/ledger.db' AS f3" :memory: "$2"
}
same_folds() { # same_folds OUT OUT
    local k
    for k in 1 2 3; do same_run "$1/fold-$k" "$2/fold-$k" || return 1; done
    for k in scores matrix dv_psnr; do cmp "$folder/$1/$k.csv" "$folder/$2/$k.csv" || return 1; done
}
all_scores=$(for f in f1 f2 f3; do
    [[ $f == f1 ]] || echo 'UNION ALL'
    echo "SELECT *, (SELECT count(*) FROM $f.image WHERE split = 'val') AS views FROM $f.score JOIN $f.image USING (image_id)"
done)

check "three folds" kfold whole --kfold 3
check "each is told" grep -qE '^ +3 +[56] +[23] +(20|24) +[0-9.]+ +[0-9.]+$' "$folder/stdout"
check "every photo but the test photo validates once" test "$(sort "$folder"/whole/fold-?/val.txt | tr '\n' ' ')" = \
    "$(printf 'view_%03d ' 0 1 2 3 4 5 6 7)"
check "and trains in the other folds" test "$(sort "$folder"/whole/fold-?/train.txt | uniq -c | grep -c '^ *2 ')" = 8
check "the test photo stays one" test "$(cat "$folder"/whole/fold-?/test.txt | sort | uniq -c | tr -s ' ')" = ' 3 view_008'
check "ledgers have these splits" test "$(query whole/fold-2 "SELECT name FROM image WHERE split = 'val' ORDER BY name")" = \
    "$(sort "$folder/whole/fold-2/val.txt")"
check "seeds count up" test "$(query whole/fold-1 'SELECT seed FROM run'),$(query whole/fold-3 'SELECT seed FROM run')" = 0,2
check "scores are means over the folds in which a photo trained" test "$(table scores.csv "SELECT count(*),
    max(abs(t.value - m.mean)) < 1e-12, min(folds), max(folds) FROM t JOIN (SELECT name, method, avg(value) AS mean, count(*) AS folds
    FROM ($all_scores) GROUP BY 1, 2) AS m
    USING (name, method) WHERE method IN ('dv_psnr', 'dv_loss', 'quality')")" = '24|1|2|2'
check "each with an interval around it" test "$(table scores.csv "SELECT count(*) FROM t WHERE method = 'dv_psnr' AND
    CAST(ci_low AS REAL) < CAST(value AS REAL) AND CAST(ci_high AS REAL) > CAST(value AS REAL) AND CAST(stderr AS REAL) > 0")" = 8
empty=$(printf " + (view_%03d = '')" 0 1 2 3 4 5 6 7) sum=$(printf ' + view_%03d' 0 1 2 3 4 5 6 7)
check "the matrix has a column per photo, empty within a fold" test "$(table matrix.csv "SELECT sum(0$empty), count(*) FROM t
    WHERE measure = 'dv_psnr'")" = '22|8'
check "its mean is that of the others" test "$(table matrix.csv "SELECT count(*) FROM t WHERE measure = 'dv_psnr' AND
    abs(mean - (0$sum) / (8 - (0$empty))) < 1e-12")" = 8
check "an entry is what a fold's ledger says" test "$(table matrix.csv "SELECT count(*), max(abs(t.mean * (8 - (0$empty)) - s.total)) < 1e-9
    FROM t JOIN (SELECT name, sum(value * views) AS total FROM ($all_scores)
    WHERE method = 'dv_psnr' GROUP BY 1) AS s USING (name) WHERE measure = 'dv_psnr'")" = '8|1'
check "the report shows the folds" grep -q 'fold-3' "$folder/whole/report.html"
check "a fold is an ordinary run" "$program" verify "$folder/whole/fold-2" --replay 5 --device llvmpipe --quiet

"$program" value "$scene" --out "$folder/whole" "${tiny[@]}" --no-thumbnails --kfold 3 >"$folder/stdout" 2>"$folder/stderr"
check "how many trainings is said" grep -qx 'kfold    3 trainings, less what is done already; Ctrl-C keeps what is done' \
    "$folder/stderr"
before=$(checksums whole)
check "again: nothing is left to do" kfold whole --kfold 3 --json
check "and nothing changes" test -n "$before" -a "$(checksums whole)" = "$before"
check "the JSON says the same" test "$(json '$.folds[2].val_psnr_end_db')" = \
    "$(query whole/fold-3 'SELECT val_psnr FROM step ORDER BY step DESC LIMIT 1')"
check "and has every photo" test "$(sqlite3 :memory: "SELECT json_array_length(CAST(readfile('$folder/stdout') AS TEXT), '\$.photos')")" = 8
cp -r "$folder/whole" "$folder/cut"
rm -r "$folder"/cut/fold-[23] "$folder"/cut/*.csv
check "a command that ended after the first fold is resumed" eval 'kfold cut --kfold 3 && same_folds whole cut'
check "fewer epochs, taken further, three together" eval 'kfold further --kfold 3 --epochs 2 && kfold further --kfold 3 --together 3 &&
    same_folds whole further'
check "folds on two devices" eval 'on_two_devices tiny kfold spread --kfold 3 && same_folds whole spread'
check "--devices is for several" on_two_devices tiny refused one '--devices is for several trainings'
check "two folds" eval 'kfold two --kfold 2 --seed 5 && [[ $(wc -l <"$folder/two/fold-1/val.txt") == 4 ]]'
check "another seed divides otherwise" test -n "$(comm -3 <(sort "$folder/two/fold-1/val.txt") <(kfold again --kfold 2 --seed 6 &&
    sort "$folder/again/fold-1/val.txt"))"

check "the scores are a list for compare" eval 'run "$program" compare "$scene" --list all --list "$folder/whole/dv_psnr.csv@-100" \
   --out "$folder/compared" "${tiny[@]}" --seeds 1 --epochs 2 --quiet --no-thumbnails'
check "select names the command to use" fails 2 'holds the folds of value --kfold; .* viewworth compare SCENE .*dv_psnr.csv@0' \
    "$program" select "$folder/whole" --rule positive --to "$folder/list.txt"
check "and takes a single fold" run "$program" select "$folder/whole/fold-1" --rule top:2 --to "$folder/list.txt"
for k in 0 1 11 x; do check "--kfold $k is refused" refused one '--kfold takes a whole number, 2 to 10' --kfold "$k"; done
check "more folds than photos are refused" refused one '--kfold 9: the scene has 8 photos' --kfold 9
check "other folds are refused" refused whole 'fold-1/train.txt: has other photos; the folder was made with another --kfold' --kfold 4
check "so is another seed" refused whole 'has other photos' --kfold 3 --seed 1
check "and another config, by name" refused whole 'fold-1 has rays = 32, not 33' --kfold 3 --rays 33
check "corruption is refused" fails 2 '--corrupt: corrupts train photos' "$lab" value "$scene" --out "$folder/one" "${tiny[@]}" \
   --quiet --kfold 3 --corrupt 2
check "a budget is for one training" refused one '--budget is for a single training' --kfold 3 --budget 10s
check "--together is for several" refused one '--together is for several trainings' --together 2
check "nothing is left of refusals" test ! -e "$folder/one"
check "a folder that holds a run is refused" refused whole/fold-1 'holds a single run' --kfold 3
rm "$folder/cut/fold-2/ledger.db" && ln -s "$folder/whole/fold-2/ledger.db" "$folder/cut/fold-2/ledger.db"
check "a link in a ledger's place is refused" refused cut 'fold-2/ledger.db: is reached through a link' --kfold 3
conclude "$@"
