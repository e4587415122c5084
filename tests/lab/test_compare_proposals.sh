#!/usr/bin/env bash
# The tables of scripts/lab/compare_proposals, on two tiny scenes: photos are hidden, proposed and added, gains are those of the
# trainings, and the same command resumes. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

sed 's/"seed": 3/"seed": 4/; s/"radius": 0.6/"radius": 0.5/' "$scene" >"$folder/other.json"
compare() {
    KNOWN=near SEEDS=1 PICKS="1 2" STEPS=18 VIEWWORTH=$program "$root/scripts/lab/compare_proposals" "$folder/out" "$scene" \
        "$folder/other.json" -- "${small[@]}" >"$folder/stdout" 2>"$folder/stderr" || { tail -n 3 "$folder/stderr"; return 1; }
}
table() { sqlite3 :memory: ".mode csv" ".import '$folder/out/$1.csv' t" ".mode list" "$2"; } # table NAME SQL
psnr() { # psnr SEED LIST: of the scene tiny
    sqlite3 :memory: ".mode csv" ".import '$folder/out/tiny/near_1/compare_$1_known/compare.csv' t" ".mode list" \
        "SELECT test_psnr FROM t WHERE list = '$2'"
}

check "two scenes are compared" compare
check "two of six photos are known" test "$(sort -u "$folder/out/tiny/near_1/known.txt" | wc -l)" = 2
check "the others are proposed" test "$(table single_gains "SELECT count(*), count(DISTINCT photo) FROM t WHERE scene = 'tiny'")" = '4|4'
check "and no known one" test "$(table single_gains 'SELECT photo FROM t' | grep -cxf "$folder/out/tiny/near_1/known.txt")" = 0
check "three methods pick one and two photos" test "$(table proposals 'SELECT count(*), count(DISTINCT method) FROM t')" = '12|3'
check "a gain is a difference of test PSNR" near "$(table proposals "SELECT gain_db FROM t WHERE scene = 'tiny' AND method = 'next'
    AND picks = 2")" "$(awk -v a="$(psnr 2001 next_2)" -v b="$(psnr 2001 known)" 'BEGIN { printf "%.12f", a - b }')"
check "the oracle begins with the largest single gain" test "$(table single_gains "SELECT photo FROM t WHERE scene = 'tiny'
    ORDER BY gain_db + 0 DESC LIMIT 1")" = "$(grep -vxf "$folder/out/tiny/near_1/known.txt" \
    "$folder/out/tiny/near_1/compare_2001_known.lists/oracle_1.names")"
mean=$(table proposals "SELECT printf('%+.2f', avg(gain_db)) FROM t WHERE method = 'random' AND picks = 1")
check "the mean over scenes is printed" says "near +1 photos  random +\\$mean "
cp "$folder/stdout" "$folder/first" && cp "$folder/out/proposals.csv" "$folder/first.csv"
check "again" compare
check "it resumes, with the same result" eval 'cmp "$folder/stdout" "$folder/first" && cmp "$folder/out/proposals.csv" "$folder/first.csv"'
check "wrong words are refused" test "$("$root/scripts/lab/compare_proposals" "$folder/none" 2>&1 | grep -c usage)" = 1
conclude "$program"
