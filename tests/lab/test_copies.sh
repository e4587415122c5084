#!/usr/bin/env bash
# The table of scripts/lab/copies, on a tiny scene: copies are the same pixels and are warned of, payouts are those of value.
# Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

copies() {
    VIEWWORTH=$program "$root/scripts/lab/copies" "$root/scenes/clean.json" "$folder/out" "$@" >"$folder/stdout" 2>"$folder/stderr"
}
table() { sqlite3 :memory: ".mode csv" ".import '$folder/out/$1' t" ".mode list" "$2"; } # table FILE SQL

check "a photo is copied, clean and harmful" copies 1 1 --epochs 3 "${small[@]}" --val-rays 64 --device llvmpipe
check "a table has a row per kind and number of times" test "$(grep -cE '^\| (clean|exposure) \| [1-4] \|' "$folder/stdout")" = 8
check "copies.csv has one per method as well" test "$(table copies.csv 'SELECT count(*), count(DISTINCT method) FROM t')" = '24|3'
check "payouts are 100 together" test "$(table copies.csv "SELECT count(*), max(abs(own_anna + own_bob - 100)) < 1e-9,
    max(abs(taken_anna + taken_bob - 100)) < 1e-9 FROM t WHERE method <> 'quality'")" = '16|1|1'
check "nobody is paid by a rank" test "$(table copies.csv "SELECT DISTINCT \"all\" || own_anna || taken_bob FROM t
    WHERE method = 'quality'")" = ''
check "a photo that is there once belongs to anna" test "$(table copies.csv "SELECT sum(own_anna <> taken_anna) FROM t
    WHERE times = '1'")" = 0
for kind in clean exposure; do
    run=${kind}_1_0_4
    check "$kind: four photos are known to be the same" test "$(table "$run/duplicates.csv" "SELECT count(*), min(similarity),
        group_concat(DISTINCT provider) FROM t")" = '4|1|anna,bob'
done
check "a photo that is there once has no duplicates" test ! -e "$folder/out/clean_1_0_1/duplicates.csv"
check "wrong words are refused" test "$(copies none; grep -c usage "$folder/stderr")" = 1
conclude "$program"
