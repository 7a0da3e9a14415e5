# shellcheck shell=bash
# A Slurm of two nodes on this machine's loopback, without systemd: one controller, two node daemons, one munge, all in one folder and on ports of their own.
# To be sourced; what needs it calls `slurm_start DIR`, and `slurm_stop` at its end. Needs root (node daemons start jobs as their owners) and Debian's slurm-wlm and munge.

# Starts controller and nodes `dpn0` and `dpn1`, a core each, and waits until both are idle.
slurm_start() {
  slurm_dir=$1
  local host
  host=$(hostname -s)
  mkdir -p "$slurm_dir"/{state,spool,log}
  chmod 755 "$slurm_dir"
  munge_dir=$(mktemp -d /tmp/dpn-munge.XXXXXX)
  dd if=/dev/urandom of="$munge_dir/key" bs=128 count=1 status=none
  chmod 600 "$munge_dir/key"
  chown -R munge: "$munge_dir"
  chmod 711 "$munge_dir"
  setpriv --reuid munge --regid munge --clear-groups munged --key-file="$munge_dir/key" --socket="$munge_dir/socket" \
    --pid-file="$munge_dir/pid" --log-file="$munge_dir/log" --seed-file="$munge_dir/seed" --force
  cat >"$slurm_dir/slurm.conf" <<CONF
ClusterName=dpn
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=17817
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$munge_dir/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
JobRequeue=1
SlurmdTimeout=5
SlurmctldTimeout=10
KillWait=2
MessageTimeout=5
SchedulerParameters=sched_interval=1,batch_sched_delay=0,requeue_delay=1
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
StateSaveLocation=$slurm_dir/state
SlurmdSpoolDir=$slurm_dir/spool/%n
SlurmctldPidFile=$slurm_dir/slurmctld.pid
SlurmdPidFile=$slurm_dir/%n.pid
SlurmctldLogFile=$slurm_dir/log/slurmctld.log
SlurmdLogFile=$slurm_dir/log/%n.log
NodeName=dpn0 NodeHostname=$host NodeAddr=127.0.0.1 Port=17818 CPUs=1 RealMemory=2048
NodeName=dpn1 NodeHostname=$host NodeAddr=127.0.0.1 Port=17819 CPUs=1 RealMemory=2048
PartitionName=all Nodes=dpn[0-1] Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF="$slurm_dir/slurm.conf"
  slurmctld-wlm -c -f "$SLURM_CONF"
  slurm_node dpn0
  slurm_node dpn1
  local waited=0
  until [ "$(sinfo -h -N -o %T 2>/dev/null | grep -c idle)" = 2 ]; do
    sleep 0.2
    waited=$((waited + 1))
    if [ $waited -gt 150 ]; then
      echo "Slurm did not come up within 30 s; its logs: $slurm_dir/log" >&2
      tail -n 5 "$slurm_dir"/log/* >&2
      return 1
    fi
  done
}

# Starts a node's daemon.
slurm_node() {
  mkdir -p "$slurm_dir/spool/$1"
  slurmd-wlm -N "$1" -f "$SLURM_CONF"
}

# Ends a node as a power cut does: its daemon and everything that it has started.
slurm_kill_node() {
  local process dying
  dying=$(cat "$slurm_dir/$1.pid")
  # What a node runs has its name in its environment; the parent of a job's first process is the step's daemon.
  # shellcheck disable=SC2013
  for process in $(grep -lsz "^SLURMD_NODENAME=$1\$" /proc/[0-9]*/environ | cut -d / -f 3); do
    dying="$dying $(ps -o ppid= -p "$process" || true) $process"
  done
  # shellcheck disable=SC2086
  kill -9 $dying 2>/dev/null || true
}

# Ends everything.
slurm_stop() {
  local file
  for file in "$slurm_dir"/*.pid "$munge_dir/pid"; do
    [ ! -e "$file" ] || kill -9 "$(cat "$file")" 2>/dev/null || true
  done
  pkill -9 slurmstepd 2>/dev/null || true
  rm -rf "$munge_dir"
}
