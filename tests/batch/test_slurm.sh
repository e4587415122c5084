#!/usr/bin/env bash
# A batch on a real Slurm of three nodes on this machine: four scenes with three seeds, one node killed on the way, then the merge; what is
# there has the canonical dump of the jobs run one after another. And a job near its time limit. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
. "$root/tests/batch/slurm.sh"
missing=$(missing_of_slurm)
[[ -z $missing ]] || { echo "SKIPPED: $missing is missing; apt-get install slurmctld slurmd slurm-client munge"; exit 77; }
[[ $(id -u) -eq 0 ]] || { echo "SKIPPED: only root may start a Slurm of its own"; exit 77; }
nodes=3 wait_s=300
trap 'stop_slurm "$folder/slurm"; rm -rf "$folder"' EXIT
chmod 755 "$folder"

# jobs_file RAYS EPOCHS SEEDS SCENES: JSON
jobs_file() {
    cat >"$folder/jobs.json" <<JSON
{"defaults": {"rays": $1, "samples": 4, "val-rays": 64, "levels": 2, "log2-table": 6, "width": 16, "effects": "none", "epochs": $2},
 "seeds": [$3], "jobs": [$4]}
JSON
}
scenes=
for scene in 1 2 3 4; do
    sed "s/\"seed\": 3/\"seed\": $scene/" "$root/tests/support/tiny.json" >"$folder/$scene.json"
    scenes+="${scenes:+, }{\"name\": \"scene-$scene\", \"scene\": \"$scene.json\"}"
done
jobs_file 256 60 0,1,2 "$scenes" # a job takes seconds, so that one is there to be killed

batch() { run "$program" batch "$folder/jobs.json" --out "$folder/$1" --devices llvmpipe "${@:2}"; }
until_true() { # until_true COMMAND...: within wait_s seconds
    local end=$((SECONDS + wait_s))
    until "$@" >/dev/null 2>&1; do
        [[ $SECONDS -lt $end ]] || { squeue; tail -n 20 "$folder/slurm/log/slurmctld" "$folder"/*/slurm-*.log; return 1; }
        sleep 0.3
    done
}
queue_is_empty() { local queue; queue=$(squeue --noheader) && [[ -z $queue ]]; }
nodes_are_idle() { [[ $(sinfo --noheader --partition=all --states=idle --Format=nodes | tr -d ' ') == "$nodes" ]]; }
runs_on() { squeue --noheader --states=running --nodelist="$1" | grep -q .; }

# ---- What is refused before anything is submitted --------------------------------------------------------------------------------

refused() { fails 2 "$1" "$program" batch "$folder/jobs.json" --out "$folder/refused" "${@:2}" && [[ ! -e $folder/refused ]]; }
check "one job of an array" refused 'leave out --job' --slurm --job 2
mkdir "$folder/bin" && printf '#!/bin/sh\nexit 1\n' >"$folder/bin/sbatch" && chmod +x "$folder/bin/sbatch"
check "a cluster that refuses" eval 'PATH=$folder/bin:$PATH fails 1 "sbatch: exit code" "$program" batch "$folder/jobs.json" \
    --out "$folder/silent" --slurm'

# ---- Four scenes, three seeds, and a node that dies ------------------------------------------------------------------------------

check "a Slurm of $nodes nodes" start_slurm "$folder/slurm" "$nodes"
check "whose nodes answer" until_true nodes_are_idle
submits() {
    batch many --slurm && cat "$folder/stdout" && grep -qE '^Submitted batch job [0-9]+$' "$folder/stdout" &&
        grep -qx '12 of 12 jobs' "$folder/stdout"
}
check "a batch is submitted" submits
check "a job begins on node 2" until_true runs_on node2
check "and the node dies" kill_node "$folder/slurm" node2
check "Slurm sees that" until_true eval 'sinfo --noheader --nodes=node2 --Format=statelong | grep -q down'
check "the queue ends" until_true queue_is_empty
check "all jobs are done, and merged" test -s "$folder/many/merged.db"
check "the others one after another" batch single --per-device 1
check "have the same canonical dump" same_dump many single
check "12 runs are in it" test "$(sqlite3 "$folder/many/merged.db" 'SELECT count(*) FROM run')" = 12
check "the lost job was started twice" grep -qE 'Requeue|requeue' "$folder/slurm/log/slurmctld"

# ---- Again, and near a time limit ------------------------------------------------------------------------------------------------

check "a batch that is done is merged here" eval 'batch many --slurm && ! grep -q ^Submitted "$folder/stdout"'
rm -r "$folder/many/scene-3/seed-1"
only_lost() {
    batch many --slurm && grep -qx '1 of 12 jobs' "$folder/stdout" &&
        squeue --noheader --array --Format=arraytaskid | grep -qw 8
}
check "a job whose folder is gone is submitted alone" only_lost
check "and done again" eval 'until_true queue_is_empty && same_dump many single'

# Slurm looks at limits every half minute; this is the signal that it sends then.
jobs_file 2048 400 0 '{"name": "a", "scene": "1.json"}'
limited_run() { [[ $(sqlite3 -readonly "$folder/limited/a/seed-0/ledger.db" "SELECT $1" 2>/dev/null) == 1 ]]; } # it may not make one
has_begun() { limited_run 'count(*) > 50 FROM step'; }
is_stopped() { limited_run "status = 'interrupted' FROM run"; }
limited() { SBATCH_TIMELIMIT=30 SBATCH_PARTITION=half batch limited --slurm; }
check "a job with the limit and the partition that the environment names" limited
check "has both" eval '[[ $(squeue --noheader --array --name=viewworth --Format=partition,timelimit | tr -s " ") == "half 30:00 " ]]'
number=$(awk '/^Submitted/ {print $4}' "$folder/stdout")
check "begins" until_true has_begun
check "hears that its limit is near" scancel --batch --signal=USR1 "${number}_1"
check "and saves what it has" until_true is_stopped
check "is queued again, and ends" until_true queue_is_empty
check "began twice" grep -q 'stopped; the same command resumes it' "$folder/limited/slurm-1.log"
check "and leaves what one does that was not stopped" eval 'batch whole && same_dump limited whole'
conclude "$@"
