#!/usr/bin/env bash
# Other ODE solvers on the hammer's map, beside ours, measured in one run: prints the table of docs/performance.md.
#
# Needs a C++ compiler with Boost's headers (Debian: apt-get install g++ libboost-dev) and Python with SciPy (a virtual
# environment is made where the python3 in the path has none). What is missing is left out of the table. About a minute
# on an idle core, after building. All is measured in processor time of one thread.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$here/../../.."
out="${1:-$here/out}"
mkdir -p "$out"
rm -f "$out"/*.csv "$out"/*.json

# The same versions of what the project itself depends on.
cp "$root/Cargo.lock" "$here/Cargo.lock"
cargo build --release --manifest-path "$here/Cargo.toml" --target-dir "${CARGO_TARGET_DIR:-$root/target}"
peers="${CARGO_TARGET_DIR:-$root/target}/release/peers"
"$peers" cells > "$out/cells.csv"

if command -v g++ > /dev/null && echo '#include <boost/numeric/odeint.hpp>' | g++ -E -x c++ - > /dev/null 2>&1; then
  g++ -std=c++17 -O3 -march=native -DNDEBUG "$here/boost.cpp" -o "$out/boost"
  # The tolerance at which all is right, and one at which nearly all still is.
  "$out/boost" "$out/cells.csv" "$out/boost" 1e-6 16
  "$out/boost" "$out/cells.csv" "$out/boost-loose" 1e-5 8
else
  echo "left out: Boost.odeint (no g++ or no Boost headers)" >&2
fi

"$peers" crate "$out"
"$peers" ours "$out"

python=python3
if ! "$python" -c 'import scipy' 2> /dev/null; then
  if [ ! -x "$out/venv/bin/python" ]; then
    python3 -m venv "$out/venv" && "$out/venv/bin/pip" -q install scipy || true
  fi
  python="$out/venv/bin/python"
fi
if "$python" -c 'import scipy' 2> /dev/null; then
  # Too slow for all: every 23rd cell, which falls on six gaps and six frequencies.
  "$python" "$here/scipy_peer.py" "$out/cells.csv" "$out" 23
else
  echo "left out: SciPy (not installed)" >&2
fi

grep -m1 "model name" /proc/cpuinfo 2> /dev/null || true
"$peers" judge "$out"
