#!/usr/bin/env bash
# OUT/field.ply in programs that are not ours: splat-transform reads it and writes SOG, SPZ and an HTML viewer, with all its splats, and
# gaussian-splats-3d shows it in headless Chromium (splat_viewer.py) as render does, at the size trained at and at four times that. Takes
# the program's path. Needs npm and its registry, chromium, chromium-driver and python3-selenium, and is skipped without them.
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

# write_path TIMES: a camera path of nerfstudio with the camera of a validation photo, that many times as large as the train photos.
write_path() {
    printf '{"render_width": %d, "render_height": %d, "camera_path": [{"fov": 38.552603, "camera_to_world": [%s]}]}' $((160 * $1)) \
        $((120 * $1)) "-0.544639, -0.419335, 0.72631, 1.888406, 0.838671, -0.27232, 0.471671, 1.226345, 0, 0.866025, 0.5, 1, 0, 0, 0, 1"
}

sed 's/"width_px": 64, "height_px": 48/"width_px": 640, "height_px": 480/' "$root/scenes/table.json" >"$folder/scene.json"
check "splats are trained" run "$program" train "$folder/scene.json" --out "$folder/out" --field splats --harmonics 2 --epochs 100 \
    --downscale 4 --effects none --device llvmpipe --quiet
for times in 1 4; do
    write_path $times >"$folder/at_$times.json"
    check "and rendered at $times times their size" run "$program" render "$folder/out" --path "$folder/at_$times.json" \
        --to "$folder/at_$times" --device llvmpipe
done
cp "$folder/out/field.ply" "$folder" # where the browser finds it
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
# show TIMES BLUR FILE=LEAST...: the viewer, which adds BLUR square pixels to splats, shows each FILE as render does, to LEAST dB.
show() {
    local -A least=()
    local file count psnr light seen=0
    for file in "${@:3}"; do least[${file%=*}]=${file#*=}; done
    while read -r file count psnr light; do
        [[ $file != no ]] || { [[ $failed -eq 0 ]] && skip "$file $count $psnr $light"; break; }
        check "the viewer has all splats of $file" test "$count" = "$splats"
        check "and shows at $1 times the size, with $2 square pixels, what render does: $psnr dB" at_least "${least[$file]}" "$psnr"
        check "which is not dark" at_least 0.02 "$light"
        seen=$((seen + 1))
    done < <(HOME=$folder XDG_CACHE_HOME=$folder "$python" "$root/tests/long/splat_viewer.py" "$folder" "at_$1" "$2" "${!least[@]}")
    check "the viewer showed all files" test "$seen" -eq "${#least[@]}"
}

# A wrong order of harmonics alone gives 31 dB; formats round. The viewer adds 0.3 square pixels where render adds 0.1: at the size trained
# at, where splats are a pixel or two wide, that is seen, so that it adds as much there; at four times the size it may add its own.
show 1 0.1 field.ply=38 field.sog.ply=34 field.spz.ply=30
show 4 0.3 field.ply=38 field.sog.ply=34 field.spz.ply=30
conclude "$@"
