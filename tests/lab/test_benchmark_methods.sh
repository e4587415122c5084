#!/usr/bin/env bash
# scripts/lab/benchmark_scenes and scripts/lab/benchmark_methods: the benchmarks that they ask for, what they pool, and a scene that
# fails. Takes the program's path, which counts photos by short trainings: a script in the laboratory's place answers for the benchmarks.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

# A benchmark of a scene notes its options, one a line, and gives dv_psnr an LDS of 0.2, and worth as many hundredths as its retrainings.
cat >"$folder/stand_in" <<END
#!/usr/bin/env bash
[[ \$1 != report ]] || exec "$lab" "\$@"
[[ \$1 == benchmark ]] || exit 2
shift
scene=\$1 out=\$3
[[ \$(cat "$folder/broken" 2>/dev/null) != "\$scene" ]] || { echo "this one is broken" >&2; exit 1; }
mkdir -p "\$out"
printf '%s\n' "\$LP_NUM_THREADS" "\$@" >"\$out/words"
worths=\$(grep -A 1 -x -e --worth-retrainings "\$out/words" | tail -n 1)
{
    echo scene,metric,method,value,ci_low,ci_high,count
    echo "\$scene,lds/val_psnr,dv_psnr,0.2,,,9"
    for worth in \${worths//,/ }; do echo "\$scene,lds/val_psnr,worth_\$worth,0.\$worth,,,9"; done
} >"\$out/benchmark.csv"
END
chmod +x "$folder/stand_in"
export VIEWWORTH_LAB=$folder/stand_in
photos() {
    rm -rf "$folder/train"
    "$program" train "$1" --out "$folder/train" --epochs 1 "${small[@]}" --quiet >/dev/null
    query train "SELECT count(*) FROM image WHERE split = 'train'"
}
row() { grep -c "^3 scenes,lds/val_psnr,$1,.*,3\$" "$folder/figure/pooled/benchmark.csv"; }

methods() { run "$root/scripts/lab/benchmark_methods" 11 3 "$folder/figure" --rays 8; }
check "the figure of three scenes" methods
for scene in "$folder"/figure/scenes/*.json; do
    name=$(basename "$scene" .json) n=$(photos "$scene")
    words="$(tr '\n' ' ' <"$folder/figure/$name/words")"
    check "$name is evaluated with its own numbers of retrainings" grep -qF -e "--worth-retrainings $((n / 2)),$n,$((2 * n)) " <<<"$words"
    check "and with all methods at all budgets" grep -qF -e '--methods all --run-equivalents 1,2,4,10,N,2N,4N ' <<<"$words"
    check "and the options of the command" grep -qF -e "0 scenes/$name.json --out $name --rays 8 " <<<"$words"
done
check "pooled over the scenes" test "$(row dv_psnr),$(row worth_N/2),$(row worth_N),$(row worth_2N)" = 1,1,1,1
check "into a report" test -s "$folder/figure/pooled/report.html"
cp "$folder/figure/pooled/benchmark.csv" "$folder/first"
check "the same command" methods
check "gives the same table" cmp "$folder/first" "$folder/figure/pooled/benchmark.csv"

other() {
    ! "$root/scripts/lab/benchmark_methods" 12 3 "$folder/figure" 2>"$folder/stderr" && grep -q 'holds other scenes' "$folder/stderr"
}
check "scenes of another seed are refused" other
broken=$(cd "$folder/figure" && ls scenes/*.json | sed -n 2p)
echo "$broken" >"$folder/broken"
fails_once() {
    ! "$root/scripts/lab/benchmark_methods" 11 3 "$folder/partly" >"$folder/stdout" 2>"$folder/stderr" &&
        grep -q "^$(basename "$broken" .json): see .*/partly/.*[.]log$" "$folder/stderr"
}
check "a scene that fails is named with its log" fails_once
check "the others are evaluated" test "$(ls -d "$folder"/partly/drawn_*/ | wc -l)" = 2
check "and nothing is pooled" test ! -e "$folder/partly/pooled/benchmark.csv"
rm "$folder/broken"
check "the same command makes up for it" eval 'run "$root/scripts/lab/benchmark_methods" 11 3 "$folder/partly" --rays 8 &&
    cmp "$folder/first" "$folder/partly/pooled/benchmark.csv"'
check "wrong words are refused" eval '! "$root/scripts/lab/benchmark_methods" 11 2>"$folder/stderr" && grep -q usage "$folder/stderr"'
conclude "$@"
