#!/usr/bin/env bash
# scripts/lab/train_predictor on tables with known weights. Takes the program's path, which it does not run.
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

# Five scenes of 30 photos: worth = 3 sharp - 1 loss + noise, in units of their own in every scene; one feature says nothing, one is
# the same for all, and one is sometimes unknown.
python3 - "$folder" <<'END'
import pathlib
import random
import sys

for scene in range(5):
    source = random.Random(scene)
    out = pathlib.Path(sys.argv[1]) / f"scene_{scene}"
    out.mkdir()
    features, worths = ["name,seed,sharp,loss,nothing,same,seldom"], ["name,worth_db,ci_low,ci_high,test_worth_db,test_ci_low,test_ci_high"]
    for photo in range(30):
        sharp, loss, nothing, noise = (source.gauss(0, 1) for _ in range(4))
        worth = (3 * sharp - loss + 0.1 * noise) * 10 ** -scene + scene
        features.append(f'"photo, {photo}",0,{100 * sharp + 7},{0.01 * loss},{nothing},4,{"" if photo % 3 else nothing}')
        worths.append(f'"photo, {photo}",{worth},,,{-worth if photo % 2 else worth},,')
    (out / "photo_features.csv").write_text("\n".join(features) + "\n")
    (out / "worths.csv").write_text("\n".join(worths) + "\n")
END

fit() { "$root/scripts/lab/train_predictor" "$@" >"$folder/stdout" 2>"$folder/stderr"; }
row() { awk -F, -v key="$1" '$1 "," $2 == key {print $3, $4, $5, $6}' "$folder/stdout"; } # row TRUTH,METRIC: its numbers
weight() { sed -n "s/^ *{\"$1\", \(.*\)},$/\1/p" "$folder/weights.h"; }
within() { awk -v x="$1" -v low="$2" -v high="$3" 'BEGIN {exit !(x != "" && x >= low && x <= high)}'; }
refused() { ! fit "${@:2}" && [[ ! -s $folder/stdout ]] && grep -q "^train_predictor: .*$1" "$folder/stderr"; }

check "five scenes are fitted" fit --to "$folder/weights.h" --provenance "Drawn in a test." "$folder"/scene_?
# 3 and -1, by the deviations of what was drawn, over that of worth within a scene: about 3 / sqrt(10) and -1 / sqrt(10)
check "the weight of what counts most" within "$(weight sharp)" 0.85 1.05
check "the weight of what counts less" within "$(weight loss)" -0.45 -0.2
check "of what does not" within "$(weight nothing)" -0.05 0.05
check "of what is the same for all" within "$(weight same)" 0 0
check "the table names its scenes" grep -q '^// .*5 scenes with 150 photos' "$folder/weights.h"
check "and where they are from" grep -q '^// Drawn in a test.$' "$folder/weights.h"
check "it is C" test "$(grep -c '^const struct vw_feature_weight vw_predictor\[\] = {$\|^};$' "$folder/weights.h")" = 2
read -r scenes found low high <<<"$(row val_psnr,spearman)"
check "scenes left out are ranked" within "$found" 0.97 1
check "all of them" test "$scenes" = 5
check "with an interval around" within "$found" "$low" "$high"
read -r _ found _ _ <<<"$(row val_psnr,r2)"
check "their variance is explained" within "$found" 0.95 1
read -r _ found _ _ <<<"$(row test_psnr,spearman)"
check "a truth of other photos is another" within "$found" -0.4 0.4
cp "$folder/weights.h" "$folder/first.h"
check "the same once more" fit --to "$folder/weights.h" --provenance "Drawn in a test." "$folder"/scene_?
check "gives the same table" cmp "$folder/first.h" "$folder/weights.h"
check "without a feature" fit --to "$folder/weights.h" --without sharp,nothing "$folder"/scene_?
check "it is not in the table" test "$(weight sharp)$(weight nothing)" = ""
read -r _ found _ _ <<<"$(row val_psnr,spearman)"
check "and missed" within "$found" 0 0.7

check "two scenes are too few" refused 'at least 3 scenes' "$folder"/scene_[01]
check "an unknown option" refused usage --fast "$folder"/scene_?
check "no benchmark" refused 'nowhere.*finished' "$folder/nowhere" "$folder"/scene_?
cp -r "$folder/scene_0" "$folder/other"
sed -i '1s/loss/cost/' "$folder/other/photo_features.csv"
check "other features" refused 'other features' "$folder"/scene_? "$folder/other"
sed -i '3s/,0,/,0,much/' "$folder/other/photo_features.csv"
check "a value that is no number" refused 'is no number' "$folder"/scene_? "$folder/other"
sed -i '3s/,0,.*/,0/' "$folder/other/photo_features.csv"
check "a line that ends early" refused 'line 3 has 2 fields' "$folder"/scene_? "$folder/other"
cp "$folder/scene_0/photo_features.csv" "$folder/other"
sed -i 2d "$folder/other/worths.csv"
check "a photo without a worth" refused 'no worth of photo, 0' "$folder"/scene_? "$folder/other"
conclude
