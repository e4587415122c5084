#!/usr/bin/env bash
# scripts/lab/pool_benchmarks on tables of known values. Takes the program's path, which it does not run.
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }
header=scene,metric,method,value,ci_low,ci_high,count

# scene NAME DV_PSNR OTHER: a benchmark in which both have that LDS.
scene() {
    mkdir -p "$folder/$1"
    printf '%s\n' "$header" "$1,lds/val_psnr,dv_psnr,$2,,,9" "\"$1, again\",lds/val_psnr,other,$3,0.1,0.9,9" >"$folder/$1/benchmark.csv"
}
pool() { "$root/scripts/lab/pool_benchmarks" "$@" >"$folder/stdout" 2>"$folder/stderr"; }
field() { awk -F, -v method="$1" -v field="$2" '$2 == method {print $field}' "$folder/stdout"; } # field METHOD NUMBER
between() { awk -v x="$1" -v low="$2" -v high="$3" 'BEGIN {exit !(x >= low && x <= high)}'; }
refused() { ! pool "${@:2}" && [[ ! -s $folder/stdout ]] && grep -q "^pool_benchmarks: .*$1" "$folder/stderr"; }

scene one 0.5 0.6
scene two 0.1 0.3
scene three 0.9 0.8
scene four 0.5 ""
check "four scenes are pooled" pool "$folder"/{one,two,three,four}
check "with the header" test "$(head -n 1 "$folder/stdout")" = metric,method,scenes,mean,ci_low,ci_high,gain,gain_ci_low,gain_ci_high,better
check "the mean over scenes" test "$(field dv_psnr 4)" = 0.5
check "a scene without a value is left out" test "$(field other 3)" = 3
check "and does not enter the mean" between "$(field other 4)" 0.56666 0.56667
check "nor the gain, of pairs" between "$(field other 7)" 0.06666 0.06667
check "on two scenes it is better" test "$(field other 10)" = 2
# Of 27 resamples of gains 0.1, 0.2, -0.1 the extreme ones, of probability 1/27, are all equal: they are the interval.
check "the interval of the gain" test "$(field other 8),$(field other 9)" = -0.1,0.2
check "the reference gains nothing over itself" test "$(field dv_psnr 7),$(field dv_psnr 8),$(field dv_psnr 9)" = 0,0,0
cp "$folder/stdout" "$folder/first"
mkdir "$folder/five"
printf '%s\n' "$header" five,lds/val_psnr,dv_psnr,0.5,,,9 >"$folder/five/benchmark.csv"
check "with a scene that lacks a method" pool "$folder"/{one,two,three,four,five}
check "this has the scenes that know it" test "$(field other 3),$(field dv_psnr 3)" = 3,5
check "a file instead of a folder" pool "$folder/one/benchmark.csv" "$folder"/{two,three,four}
check "gives the same bytes" cmp "$folder/first" "$folder/stdout"
check "a single scene" pool "$folder/one"
check "has no interval" test "$(field other 4),$(field other 5),$(field other 6)" = 0.6,,
for name in six seven; do
    mkdir "$folder/$name"
    printf '%s\n' "$header" "$name,lds/val_psnr,dv_psnr,0.5,,,9" "$name,lds/val_psnr,worth_${#name}0,0.2,,,9" \
        "$name,lds/val_psnr,worth_9,0.4,,,9" >"$folder/$name/benchmark.csv"
done
check "scenes with numbers of retrainings of their own" pool --worths few,many "$folder"/{six,seven}
check "have the names that are given" test "$(field worth_few 3),$(field worth_few 4),$(field worth_many 4)" = 2,0.4,0.2
check "one name for two numbers" refused 'has 2' --worths few "$folder/six"
check "as a benchmark of all scenes" pool --benchmark "$folder"/{one,two,three,four}
check "with the header of one" test "$(head -n 1 "$folder/stdout")" = "$header"
check "and the same means" test "$(grep '^4 scenes,lds/val_psnr,other,' "$folder/stdout" | cut -d, -f4,7)" = \
    "$(awk -F, '$2 == "other" {print $4","$3}' "$folder/first")"
check "an unknown option" refused '--other: is no option' --other "$folder/one"
check "no benchmark" refused 'nowhere.*finished' "$folder/one" "$folder/nowhere"
echo name,score >"$folder/scores.csv"
check "another table" refused 'scores.csv: is no benchmark.csv' "$folder/scores.csv"
printf '%s\n' "$header" "one,lds/val_psnr,dv_psnr,much,,,9" >"$folder/text.csv"
check "a value that is no number" refused 'text.csv: line 2' "$folder/text.csv"
check "nothing to pool" refused usage
conclude
