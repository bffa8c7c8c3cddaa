#!/usr/bin/env bash
# Tries the array scripts against a real Slurm on this machine: installs slurmctld, slurmd and munge (Debian, as
# root), starts a cluster of one node with no more than this machine's processors, submits the array and the merge
# behind it, waits, and compares the files byte by byte with those of a plain run.
#
#   docs/cluster/try.sh [options of host-sim map]
#
# Meant for a machine of your own that has no Slurm yet: it refuses to touch one that is configured. Everything it
# starts ends with it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
here=$PWD/docs/cluster
options=("$@")
[ $# -gt 0 ] || options=(--gap 0:3.5:0.05 --frequency 1.41:7.28:0.02)

fail() {
  echo "error: $*" >&2
  exit 1
}

[ "$(id -u)" -eq 0 ] || fail "this starts Slurm's daemons: run it as root, on a machine of your own"
[ ! -e /etc/slurm/slurm.conf ] || fail "/etc/slurm/slurm.conf is there: this machine has a Slurm; use sbatch with $here/map.sbatch"

if ! command -v slurmctld slurmd munged sbatch >/dev/null; then
  command -v apt-get >/dev/null || fail "install slurmctld, slurmd, slurm-client and munge first"
  echo "installing slurmctld, slurmd, slurm-client and munge"
  apt-get -q update >/dev/null
  DEBIAN_FRONTEND=noninteractive apt-get -q install -y --no-install-recommends \
    slurmctld slurmd slurm-client munge >/dev/null
fi

if [ -z "${HOST_SIM:-}" ]; then
  cargo build --release --package host-sim
  HOST_SIM=${CARGO_TARGET_DIR:-target}/release/host-sim
fi
HOST_SIM=$(realpath "$HOST_SIM")
export HOST_SIM

work=$(mktemp -d /tmp/slurm-try-XXXXXX)
started=()
cleanup() {
  for pid in "${started[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  if [ -n "${KEEP:-}" ]; then echo "kept $work"; else rm -rf "$work"; fi
}
trap cleanup EXIT

# munge: who may talk to whom. Its key is made for this run.
mkdir -m 700 "$work/munge"
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod 600 "$work/munge/key"
chmod 755 "$work"
mkdir -m 755 "$work/socket"
munged --foreground --force --key-file="$work/munge/key" --socket="$work/socket/munge" \
  --pid-file="$work/munge/pid" --log-file="$work/munge/log" --seed-file="$work/munge/seed" \
  >"$work/munge/out" 2>&1 &
started+=($!)

# Two ports that nothing listens on.
port() { for p in $(seq "$1" $(($1 + 200))); do (: <"/dev/tcp/127.0.0.1/$p") 2>/dev/null || { echo "$p"; return; }; done; }
name=$(hostname -s)
mkdir -p "$work/state" "$work/spool"
cat >"$work/slurm.conf" <<CONF
ClusterName=try
SlurmctldHost=$name(127.0.0.1)
SlurmUser=root
SlurmctldPort=$(port 26817)
SlurmdPort=$(port 27818)
AuthType=auth/munge
AuthInfo=socket=$work/socket/munge
CryptoType=crypto/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
NodeName=$name NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$name Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf

slurmctld -D -f "$SLURM_CONF" >"$work/slurmctld.out" 2>&1 &
started+=($!)
slurmd -D -f "$SLURM_CONF" -N "$name" >"$work/slurmd.out" 2>&1 &
started+=($!)

for _ in $(seq 60); do
  sinfo --noheader --format=%T 2>/dev/null | grep -q idle && break
  sleep 1
done
sinfo --noheader --format=%T 2>/dev/null | grep -q idle || {
  tail -n 20 "$work"/slurmctld.log "$work"/slurmd.log "$work"/*.out "$work/munge/log" >&2 || true
  fail "the cluster did not come up"
}
echo "$(slurmctld -V): one node, $(nproc) processors"

cd "$work"
tasks=7
array=$(sbatch --parsable --array=1-$tasks "$here/map.sbatch" "$work/shared" "${options[@]}")
merge=$(sbatch --parsable --dependency="afterok:$array" "$here/map-merge.sbatch" "$work/shared" "${options[@]}")
echo "array $array of $tasks tasks, merge $merge behind it"
for _ in $(seq 600); do
  [ -n "$(squeue --noheader)" ] || break
  sleep 1
done
[ -z "$(squeue --noheader)" ] || fail "jobs still stand in the queue after ten minutes"
for job in "$array" "$merge"; do
  scontrol --oneliner show job "$job" | while read -r line; do
    grep -o ' ArrayTaskId=[0-9]*\| JobName=[a-z-]*\| JobState=[A-Z]*\| RunTime=[0-9:]*' <<<" $line" | tr -d '\n'
    echo
  done
done
grep -h . "$work"/map-[0-9]*.log "$work"/map-merge-*.log

echo "the same map in one go"
"$HOST_SIM" map "${options[@]}" --out "$work/plain" --quiet >/dev/null
compgen -G "$work/shared/*.csv" >/dev/null || fail "the merge left no table"
diff -r "$work/shared" "$work/plain" || fail "the files differ"
(cd "$work/shared" && sha256sum -- *)
echo "same bytes: $(find "$work/shared" -type f | wc -l) files"
