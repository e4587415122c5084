# A Slurm cluster of several nodes on this machine alone, to be sourced: munged, slurmctld and a slurmd per node, all from Debian's
# packages, with all their files in one folder.

missing_of_slurm() { # the first of its programs that is missing
    local program
    for program in munged slurmctld slurmd sbatch squeue scontrol; do
        PATH=$PATH:/usr/sbin:/sbin command -v "$program" >/dev/null || { echo "$program"; return; }
    done
}

write_slurm_configuration() { # write_slurm_configuration FOLDER NODES
    local folder=$1 node host
    host=$(hostname -s)
    cat <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$((20000 + $$ % 4000))
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket,cred_expire=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool.%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.%n.pid
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/slurmd.%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=0
SlurmdTimeout=6
KillWait=5
END
    for ((node = 1; node <= $2; node++)); do
        echo "NodeName=node$node NodeHostname=$host NodeAddr=127.0.0.1 Port=$((24000 + $$ % 4000 * 8 + node)) CPUs=1 RealMemory=500"
    done
    echo "PartitionName=all Nodes=node[1-$2] Default=YES MaxTime=INFINITE State=UP"
    echo "PartitionName=half Nodes=node1 MaxTime=INFINITE State=UP"
}

# start_slurm FOLDER NODES: exports SLURM_CONF, by which sbatch and the others find it. Its partitions are all, the default, and half,
# which has the first node alone.
start_slurm() {
    local folder=$1 node
    PATH=$PATH:/usr/sbin:/sbin
    mkdir -p "$folder/state" "$folder/log" && chmod 755 "$folder" || return
    head -c 1024 /dev/urandom >"$folder/munge.key" && chmod 600 "$folder/munge.key" || return
    munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
        --log-file="$folder/log/munged" --seed-file="$folder/munge.seed" || return
    write_slurm_configuration "$folder" "$2" >"$folder/slurm.conf" || return
    export SLURM_CONF=$folder/slurm.conf
    slurmctld || return
    for ((node = 1; node <= $2; node++)); do slurmd -N "node$node" || return; done
}

kill_tree() { # kill_tree PROCESS: it and all that it started, at once
    local child
    kill -STOP "$1" 2>/dev/null
    for child in $(pgrep -P "$1"); do kill_tree "$child"; done
    kill -KILL "$1" 2>/dev/null
}

# kill_node FOLDER NODE: as a node dies whose power is cut. Nobody is left to say how a job ended: slurmstepd, which runs the script of a
# job and is no child of slurmd, ends before it does.
kill_node() {
    local script process
    process=$(<"$1/slurmd.$2.pid")
    kill_tree "$process"
    for script in $(pgrep -f "$1/spool.$2/job"); do
        process=$(ps -o ppid= -p "$script")
        [[ -z $process || $process -le 1 ]] || kill_tree "$((process))"
    done
}

stop_slurm() { # stop_slurm FOLDER: and waits until nobody writes there
    local processes process i
    processes=$(cat "$1"/*.pid 2>/dev/null)
    for process in $processes; do kill "$process" 2>/dev/null; done
    for process in $processes; do
        for ((i = 0; i < 50; i++)); do
            kill -0 "$process" 2>/dev/null || break
            sleep 0.1
        done
    done
}
