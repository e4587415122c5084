#!/usr/bin/env bash
# A valuation on a second Vulkan driver, SwiftShader, whose compiler, limits and rounding are others than lavapipe's: it ends in
# time, and its scores are lavapipe's within rounding. Takes the program's path. The driver comes with Debian's chromium and is found
# there; VIEWWORTH_SWIFTSHADER names another vk_swiftshader_icd.json.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

for second in "${VIEWWORTH_SWIFTSHADER:-}" /usr/lib/chromium/vk_swiftshader_icd.json /opt/google/chrome/vk_swiftshader_icd.json; do
    [[ -f $second ]] && break
done
[[ -f $second ]] || { echo "SKIPPED: no vk_swiftshader_icd.json; install chromium, or name one by VIEWWORTH_SWIFTSHADER"; exit 77; }
options=(--rays 64 --samples 16 --val-rays 64 --epochs 6 --effects none) # all levels and the full width: the most to compile
tiny=$root/tests/support/tiny.json

value_second() { VK_DRIVER_FILES=$second VK_ICD_FILENAMES=$second timeout 120 "$program" value "$tiny" --out "$folder/$1" "${options[@]}"; }
rows() { sqlite3 "$folder/$1/ledger.db" "$2"; }
last_psnr="select val_psnr from step order by step desc limit 1"
scores="select image_id, value from score where method = 'dv_psnr' order by image_id"
near() { # near TOLERANCE: two columns of numbers on stdin
    awk -v tolerance="$1" '{ d = $1 - $2; if (d < 0) d = -d; if (!(d <= tolerance)) { print "off by", d, "in line", NR; bad = 1 } }
                           END { exit bad || NR == 0 }'
}
psnr_is_near() { paste <(rows first "$last_psnr") <(rows second "$last_psnr") | near 0.05; }
scores_are_near() { paste <(rows first "$scores") <(rows second "$scores") | tr '|' ' ' | awk '{ print $2, $4 }' | near 0.02; }
same_rows() { cmp <(rows second "$1") <(rows again "$1"); }

check "lavapipe" run "$program" value "$tiny" --out "$folder/first" "${options[@]}" --device llvmpipe
check "the second driver ends in time" run value_second second
check "it was SwiftShader" grep -q SwiftShader "$folder/stderr"
check "no step is not finite" test "$(rows second "select count(*) from step where nonfinite")" = 0
check "the same PSNR at the end" psnr_is_near
check "the same scores" scores_are_near
if [[ -n ${VIEWWORTH_FULL:-} ]]; then
    check "and again" run value_second again
    check "bit for bit" same_rows "select step, quote(train_loss), quote(val_psnr) from step order by step"
fi
conclude
