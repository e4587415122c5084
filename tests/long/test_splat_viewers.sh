#!/usr/bin/env bash
# OUT/field.ply in programs that are not ours: splat-transform reads it and writes SOG, SPZ and an HTML viewer, with all its splats, and
# gaussian-splats-3d shows it in headless Chromium (splat_viewer.py) as render does. Takes the program's path. Needs npm and its registry,
# chromium, chromium-driver and python3-selenium, and is skipped without them.
# label: unsanitized
. "$(dirname "$0")/../support/program_test.sh"
skip() { echo "SKIPPED: splats were not seen in other programs: $1"; exit 77; }
python=${PYTHON:-/usr/bin/python3}
command -v npm >/dev/null || skip "npm is missing; apt-get install npm"
[[ -x ${CHROMIUM:-/usr/bin/chromium} && -x ${CHROMEDRIVER:-/usr/bin/chromedriver} ]] && "$python" -c 'import selenium' 2>/dev/null ||
    skip "install chromium, chromium-driver and python3-selenium"
npm ping --fetch-retries 0 --fetch-timeout 60000 >"$folder/stdout" 2>&1 || skip "the registry does not answer npm ping"

installs() { # without peers of the converter, which draw
    run npm install --prefix "$folder" --no-audit --no-fund --ignore-scripts --legacy-peer-deps "$@"
}
transform() {
    run "$folder/node_modules/node-linux-$architecture/bin/node" "$folder/node_modules/@playcanvas/splat-transform/bin/cli.mjs" \
        --quiet --gpu cpu "$@"
}
holds_all() { # holds_all FILE: as many splats as field.ply
    transform "$folder/$1" --info json null && [[ $(json '$.numGaussians') == "$splats" ]] && return
    cat "$folder/stdout"
    return 1
}
writes() { transform "$folder/field.ply" "$folder/field.$1"; }
reads() { transform "$folder/$1" "$folder/$1.ply"; }
html_holds_all() { # the file that its page carries
    grep -oE '"contentUrl":"data:[a-z/-]+;base64,[A-Za-z0-9+/=]+' "$folder/field.html" | sed 's/.*,//' | base64 -d >"$folder/carried.sog" &&
        holds_all carried.sog
}
at_least() { # at_least LIMIT FIGURE
    awk -v limit="$1" -v figure="$2" 'BEGIN {exit !(figure >= limit)}' || { echo "$2 is below $1"; return 1; }
}

# ---- A field ----

sed 's/"width_px": 64, "height_px": 48/"width_px": 160, "height_px": 120/' "$root/scenes/table.json" >"$folder/scene.json"
check "splats are trained" run "$program" train "$folder/scene.json" --out "$folder/out" --field splats --harmonics 2 --epochs 100 \
    --downscale 1 --effects none --device llvmpipe --quiet
check "and a validation photo rendered" run "$program" render "$folder/out" --to "$folder/render.png" --device llvmpipe
mv "$folder/out/field.ply" "$folder" # where the browser finds it
splats=$(head -c 4096 "$folder/field.ply" | sed -nE 's/^element vertex ([0-9]+)$/\1/p' | head -n 1)
check "there are many" test "${splats:-0}" -ge 1000

# ---- In splat-transform ----

architecture=$(node -p process.arch) # splat-transform needs a newer node than Debian has
check "npm installs programs" installs @playcanvas/splat-transform@3.7.0 "node-linux-$architecture@22.23.3" \
    @mkkellogg/gaussian-splats-3d@0.4.7 three@0.187.0
check "splat-transform reads all splats" holds_all field.ply
for kind in sog spz html; do check "and writes .$kind" writes "$kind"; done
for kind in sog spz; do
    check ".$kind has all splats" holds_all "field.$kind"
    check "and is read again" reads "field.$kind"
done
check ".html has all splats" html_holds_all

# ---- In a viewer ----

cp "$root/tests/long/splat_viewer.html" "$folder"
# A wrong order of harmonics alone gives 31 dB; formats round.
declare -A least=([field.ply]=38 [field.sog.ply]=34 [field.spz.ply]=30)
seen=0
while read -r file count psnr light; do
    [[ $file != no ]] || { [[ $failed -eq 0 ]] && skip "$file $count $psnr $light"; break; }
    check "the viewer has all splats of $file" test "$count" = "$splats"
    check "and shows what render does: $psnr dB" at_least "${least[$file]}" "$psnr"
    check "which is not dark" at_least 0.02 "$light"
    seen=$((seen + 1))
done < <(HOME=$folder XDG_CACHE_HOME=$folder "$python" "$root/tests/long/splat_viewer.py" "$folder" "${!least[@]}")
check "the viewer showed all files" test "$seen" -eq "${#least[@]}"
conclude "$@"
