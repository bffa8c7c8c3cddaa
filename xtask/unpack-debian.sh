#!/bin/sh
# Unpacks Debian's packages and all they depend on, and installs nothing: apt resolves and downloads in a folder of its own.
# Neither root nor the system's package lists are needed.
#
#     unpack-debian.sh FOLDER 'PACKAGE...' 'PROGRAM...'
#
# FOLDER/starters gets a script for each program (of usr/bin, or as a path below usr) that starts it with the libraries in
# FOLDER, wherever that is moved. FOLDER appears when it is whole; the first line of FOLDER/packages says what was asked for.
set -eu
folder=$1 packages=$2 programs=$3

# Left to the system: the C library (two of them in one process do not work), the C compiler, which Rust needs on every
# machine, and what serves installation only.
from_system='libc6|libc-|libcrypt|libgcc|linux-libc-dev|gcc|cpp|binutils|libbinutils|libctf|libgprofng|libasan|liblsan'
from_system="$from_system|libtsan|libubsan|libcc1|libisl|libmpc|libmpfr|debconf|adduser|passwd|libpam-modules|iso-codes"

mkdir -p "$(dirname "$folder")"
# The system releases it when this process ends, however it ends.
exec 9>"$(dirname "$folder")/lock"
flock -n 9 || { echo "waiting for another run that unpacks tools"; flock 9; }
[ "$(head -n 1 "$folder/packages" 2>/dev/null)" != "wanted: $packages" ] || exit 0
echo "unpacking Debian's $packages into $folder (nothing is installed)"

part=$folder.part
rm -rf "$part"
trap 'rm -rf "$part"' EXIT
tree=$part/tree
mkdir -p "$part/lists/partial" "$part/cache/archives/partial" "$part/debs" "$tree/starters"
: >"$part/status"
# Hooks of the system's configuration are not run.
cat >"$part/apt.conf" <<CONFIG
Dir::State "$part"; Dir::State::Lists "$part/lists"; Dir::State::status "$part/status";
Dir::Cache "$part/cache"; Dir::Log "$part";
APT::Sandbox::User ""; Debug::NoLocking "true";
Acquire::Languages "none"; Acquire::IndexTargets::deb::DEP-11::DefaultEnabled "false";
Acquire::Retries "2"; Acquire::http::Timeout "30"; Acquire::https::Timeout "30";
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
#clear DPkg::Pre-Invoke;
#clear DPkg::Post-Invoke;
CONFIG
apt() { (cd "$part/debs" && LC_ALL=C apt-get -c "$part/apt.conf" -q "$@"); }

apt update >/dev/null
# shellcheck disable=SC2086 # Several packages in one word.
simulated=$(apt -s install --no-install-recommends $packages)
# "Inst name (version ..." is what it would install.
found=$(echo "$simulated" | sed -n 's/^Inst \([^ ]*\) (\([^ )]*\).*/\1=\2/p' | grep -Ev "^($from_system)")
# shellcheck disable=SC2086
apt download $found >/dev/null
for deb in "$part"/debs/*.deb; do dpkg-deb -x "$deb" "$tree"; done
# Of Rust's sources, 440 MB, only those of its library are needed.
rm -rf "$tree"/usr/src/*/src "$tree"/usr/src/*/compiler

# A link to /usr/... would lead out of the tree: it is made to lead to the same file within.
find "$tree" -type l -lname '/*' | while read -r link; do
  target=$(readlink "$link")
  [ -e "$tree$target" ] || [ -L "$tree$target" ] || continue
  inside=${link#"$tree"/}
  ln -sfn "$(echo "$inside" | sed 's,[^/]*$,,; s,[^/][^/]*,..,g; s,/$,,; s,^$,.,')$target" "$link"
done

libraries=
for place in "$tree"/lib/*-linux-* "$tree"/usr/lib/*-linux-* "$tree"/usr/lib/*-linux-*/pulseaudio; do
  [ ! -d "$place" ] || libraries="${libraries:+$libraries:}\$tree${place#"$tree"}"
done
for program in $programs; do
  starter=$tree/starters/${program##*/}
  case $program in */*) ;; *) program=bin/$program ;; esac
  cat >"$starter" <<STARTER
#!/bin/sh
# Starts $program from the packages unpacked here, with their libraries and letters.
tree=\$(dirname "\$(dirname "\$(readlink -f "\$0")")")
export LD_LIBRARY_PATH="$libraries\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
[ ! -d "\$tree/etc/fonts" ] || export FONTCONFIG_SYSROOT="\$tree"
exec "\$tree/usr/$program" "\$@"
STARTER
  chmod 755 "$starter"
  # It may lack a library.
  "$starter" --version >/dev/null
done
{ echo "wanted: $packages"; echo "$found"; } >"$tree/packages"
rm -rf "$folder"
mv "$tree" "$folder"
