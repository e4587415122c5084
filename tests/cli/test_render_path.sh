#!/usr/bin/env bash
# render --path and --pose from outside: frames, their sizes and bits, videos with and without ffmpeg. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
out=$folder/run
render() { run "$program" render "$out" "$@" --device llvmpipe --quiet; }
refuses() { fails 2 "$1" "$program" render "$out" "${@:2}" --device llvmpipe --quiet; } # refuses PATTERN ARGUMENT...
size() { od -An -tu4 --endian=big -j16 -N8 "$1" | xargs; }                               # of a PNG
frames() { find "$1" -name 'frame_*.png' | wc -l; }
no_programs=$folder/none
mkdir "$no_programs"

check "a run" run "$program" value "$scene" --out "$out" --epochs 3 "${small[@]}"
check "a view beside its photo" render --view 0 --to "$folder/pair.png"
check "cameras of the scene" run "$program" export "$out" --cameras "$folder/cameras.json" --device llvmpipe
pose=$(sqlite3 :memory: "SELECT group_concat(number.value, ' ') FROM
    (SELECT value FROM json_each(CAST(readfile('$folder/cameras.json') AS TEXT), '\$.cameras') WHERE value ->> '\$.split' = 'val' LIMIT 1)
    AS camera, json_each(camera.value, '\$.camera_to_world') AS line, json_each(line.value) AS number")
check "a pose" render --pose "$pose" --to "$folder/pose.png"
check "is half as wide" test "$(size "$folder/pair.png"), $(size "$folder/pose.png")" = "32 12, 16 12"
check "a pose without a name is in OUT" eval 'render --pose "$pose" && cmp "$out/render_pose.png" "$folder/pose.png"'
check "a pose of 3 numbers is refused" refuses '--pose: give the 12 or 16 numbers' --pose "1 2 3"

check "an orbit" render --path orbit --frames 5 --to "$folder/orbit"
check "has its frames" test "$(frames "$folder/orbit"), $(size "$folder/orbit/frame_0005.png")" = "5, 16 12"
check "which differ" eval '! cmp -s "$folder/orbit/frame_0001.png" "$folder/orbit/frame_0003.png"'
check "again" render --path orbit --frames 5
check "it has the same bits" diff -r "$folder/orbit" "$out/frames"
check "a shorter path leaves no frames of a longer one" eval 'render --path cameras --frames 2 && [[ $(frames "$out/frames") == 2 ]]'
check "nine frames through nine cameras" render --path cameras --frames 9 --to "$folder/through"
check "one of them is that view" eval 'sha256sum <"$folder/pose.png" | grep -qf - <(sha256sum "$folder/through/"* | sed "s/ .*/  -/")'
check "--json says what was written" answers "j ->> '\$.to' = '$folder/three' AND j ->> '\$.frames' = 3 AND j ->> '\$.video' IS NULL" \
    "$program" render "$out" --path orbit --frames 3 --to "$folder/three" --device llvmpipe --quiet --json

check "depths of frames" render --path orbit --frames 2 --to "$folder/deep" --depth
check "are beside them" test "$(ls "$folder/deep" | xargs)" = \
    "frame_0001.png frame_0001_depth.exr frame_0002.png frame_0002_depth.exr"
check "a view's" eval 'render --view 0 --to "$folder/d.exr" --depth && [[ -s $folder/d_depth.exr ]]'
check "are those of its pose" eval 'render --pose "$pose" --to "$folder/p.png" --depth && cmp "$folder/p_depth.exr" "$folder/d_depth.exr"'
check "and go with frames without" eval 'render --path orbit --frames 2 --to "$folder/deep" && [[ $(ls "$folder/deep" | wc -l) == 2 ]]'
check "and with those of a longer path" eval 'render --path orbit --frames 2 --depth && render --path orbit --frames 1 --depth &&
    [[ $(ls "$out/frames" | xargs) == "frame_0001.png frame_0001_depth.exr" ]]'
check "a folder elsewhere with frames of a longer path is refused" refuses 'deep/frame_0002.png: is of a longer path' --path orbit \
    --frames 1 --to "$folder/deep"
check "and keeps them" test "$(frames "$folder/deep")" = 2

sqlite3 :memory: "SELECT json_object('render_width', 20, 'render_height', 14, 'camera_path', json_array(json_object('fov', 50,
    'camera_to_world', json('[' || replace('$pose', ' ', ',') || ']'))))" >"$folder/path.json"
check "a file" render --path "$folder/path.json" --to "$folder/file"
check "decides number and size of frames" test "$(frames "$folder/file"), $(size "$folder/file/frame_0001.png")" = "1, 20 14"
printf '{"camera_path": [], "render_width": -1}' >"$folder/bad.json"
check "a bad file is refused by its field" refuses 'bad\.json: render_width: ' --path "$folder/bad.json"
check "so is one that is not there" refuses 'nowhere' --path nowhere
check "a pose and a path are refused" refuses 'give one of them' --path orbit --pose "$pose"
check "a video without a path is refused" refuses '--video' --video "$folder/v.mp4"
check "another kind of video is refused" refuses 'must end in .mp4 or .gif' --path orbit --video "$folder/v.avi"
mkdir "$folder/elsewhere" && rm -r "$out/frames" && ln -s "$folder/elsewhere" "$out/frames"
check "a link in OUT is not followed" refuses 'frames' --path orbit
rm "$out/frames"

check "a video without ffmpeg is refused" fails 2 'ffmpeg is not installed' env PATH="$no_programs" "$program" render "$out" \
    --path orbit --frames 3 --video "$folder/v.mp4" --device llvmpipe --quiet
check "before anything is rendered" test ! -e "$out/frames"
if command -v ffmpeg >/dev/null; then
    for kind in mp4 gif; do
        check "$kind" render --path orbit --frames 3 --to "$folder/100% off" --video "$folder/v.$kind"
        check "has the frames" test "$(ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 \
            "$folder/v.$kind")" = 16,12,3
        cp "$folder/v.$kind" "$folder/first.$kind"
        check "again, over it" render --path orbit --frames 3 --to "$folder/100% off" --video "$folder/v.$kind"
        check "the same bits" cmp "$folder/v.$kind" "$folder/first.$kind"
    done
    check "nothing but frames is left" test "$(find "$folder/100% off" -type f | wc -l)" = 3
else
    echo "SKIPPED: videos: ffmpeg is missing; apt-get install ffmpeg"
fi
conclude "$@"
